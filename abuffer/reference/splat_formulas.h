// What a splat is by formulas of the reference's own: colours, harmonics, motion.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "splat/splat_cloud.h"

namespace swept::reference {

/// IEC 61966-2-1, continued oddly below 0 and by its formula above 1.
[[nodiscard]] double decoded(double s);
[[nodiscard]] double encoded(double linear);

/// Real spherical harmonics with the signs of Kerbl et al.; degree by degree, orders −l … l.
[[nodiscard]] std::array<double, 16> harmonics_towards(const Eigen::Vector3d& direction);

/// A splat of its own motion, Li et al. 2024 (SpacetimeGaussians): with Δt since its centre in time its
/// position is a cubic, its quaternion a line that is normalised, and its opacity a bell. The last three are
/// the cloud's, and then those at `frame`. Precondition: the cloud has motion.
void move_by_itself(const SplatCloud& cloud, std::size_t splat, double frame, Eigen::Vector3d& position,
                    Eigen::Quaterniond& rotation, double& opacity);

}  // namespace swept::reference
