// Colours and the small functions textures are made of.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include "splat/srgb.h"

namespace swept::datasets {

inline constexpr double kPi = std::numbers::pi;

/// Linear Rec.709 of an sRGB colour written 0xRRGGBB, as one picks them by eye.
[[nodiscard]] inline Eigen::Vector3d srgb(unsigned hex) {
  const auto linear = [](unsigned byte) { return srgb_to_linear(byte / 255.0); };
  return {linear((hex >> 16) & 255u), linear((hex >> 8) & 255u), linear(hex & 255u)};
}

[[nodiscard]] inline Eigen::Vector3d mix(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double t) {
  return a + t * (b - a);
}

/// 0 below `from`, 1 above `to`, cubic between; from > to falls.
[[nodiscard]] inline double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Cell number of x modulo `count`, x in cells; defined for any finite x.
[[nodiscard]] inline int cell(double x, int count) {
  return static_cast<int>(std::floor(x - count * std::floor(x / count))) % count;
}

}  // namespace swept::datasets
