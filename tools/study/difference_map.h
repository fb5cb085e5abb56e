// Where two images differ, as colours on a logarithmic scale.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "splat/image.h"

namespace swept {

/// Largest channel differences at the two ends of the scale; what is beyond has the end's colour.
inline constexpr double kDifferenceLow = 1e-4, kDifferenceHigh = 0.1;

/// The scale's colours, sRGB, at even steps of the difference's logarithm: from black over purple and orange
/// to pale yellow, of growing lightness, so that they read the same in grey.
[[nodiscard]] const std::vector<std::array<int, 3>>& difference_colors();

/// As write_png() takes it. `a` and `b` have the same window.
[[nodiscard]] Image difference_map(const Image& a, const Image& b);

}  // namespace swept
