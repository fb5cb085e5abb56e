// The scenes of datasets/, embedded at build, so that the program has them wherever it is installed.
#pragma once

#include <string_view>

namespace swept {

/// The text of datasets/NAME, e.g. "knot.json"; empty if there is none of that name.
[[nodiscard]] std::string_view scene_asset(std::string_view name);

}  // namespace swept
