// What someone may have meant by a word that is not known. For the project's own sources.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "splat/export.h"

namespace SWEPT_API swept {

/// The one of `known` that `word` is a slip away from, or that alone begins with it; empty: none is near.
[[nodiscard]] std::string_view nearest_word(std::string_view word, std::span<const std::string_view> known);

/// "; did you mean ...?" where one of `known` is near, else the list of them.
[[nodiscard]] std::string suggestion(std::string_view word, std::span<const std::string_view> known);

}  // namespace swept
