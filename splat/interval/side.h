// The two sides of a disc, which are two surfaces where they can be told apart (model section 1.2).
#pragma once

#include <cstdint>

#include "splat/export.h"

namespace SWEPT_API swept {

/// Which side of its disc a fragment shows. Two of them are one surface only if both_sides() is false.
enum class Side : std::uint32_t { unknown = 0, front = 1, back = 2 };

/// Whether front and back are among those that were or-ed together.
[[nodiscard]] constexpr bool both_sides(std::uint32_t sides) { return sides == 3; }
[[nodiscard]] constexpr bool both_sides(Side a, Side b) {
  return both_sides(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
/// Of fragments that are equally near, those of the least rank lead.
[[nodiscard]] constexpr int rank_of(Side side) {
  return side == Side::front ? 0 : side == Side::unknown ? 1 : 2;
}

}  // namespace swept
