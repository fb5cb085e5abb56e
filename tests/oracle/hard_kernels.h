// Random kernels of every hard case of model section 10, seeded, each with a ray at or near it.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "splat/kernel/moving_kernel.h"

namespace swept::oracle {

using Random = std::mt19937_64;

struct KernelAndRay {
  MovingKernel kernel;
  double x = 0.0, y = 0.0;  ///< the ray (x, y, 1)
};

struct HardCase {
  std::string name;
  KernelAndRay (*make)(Random&);
  bool invertible;  ///< whether [a₁ a₂ m c] is, and its condition leaves digits
};

/// A camera of 1000 px focal length; near plane at near_depth.
inline constexpr double focal_px = 1000.0;
inline constexpr double near_depth = 0.1;

[[nodiscard]] const std::vector<HardCase>& hard_cases();

[[nodiscard]] double uniform(Random& random, double low, double high);
/// ± 10^x, x uniform in [low, high].
[[nodiscard]] double magnitude(Random& random, double low, double high);
[[nodiscard]] Eigen::Vector3d direction(Random& random);

}  // namespace swept::oracle
