// The motion as the paper's matrix needs it, to compare with.
//
// Source: Heinzle et al. 2010, section 5.2. The paper inverts [a₁ a₂ m c], which is singular where the motion
// m lies in the disc's plane, and so gives m a least length and a least angle to that plane. Kernels here
// need neither (model section 2); where the matrix is regular both give the same numbers. So the paper's
// error is had by bending the motion alone.
#pragma once

#include "splat/kernel/moving_kernel.h"

namespace swept {

/// The paper gives no numbers; these are 3° and a twentieth of the disc's radius.
inline constexpr double least_motion_tangent = 0.05;
inline constexpr double least_motion_radii = 0.05;

/// The kernel's velocity, lengthened along the disc's normal until it stands out of the disc's plane, and
/// then until it is long enough; as it was where it does and is. A disc without an area keeps its velocity.
[[nodiscard]] Eigen::Vector3d clamped_motion(const MovingKernel& kernel);

}  // namespace swept
