#include "gpu_passes/six_pass/clamp_motion.h"

#include <cmath>

#include <Eigen/Geometry>

namespace swept {

Eigen::Vector3d clamped_motion(const MovingKernel& kernel) {
  const Eigen::Vector3d a = kernel.axis_u.cast<double>(), b = kernel.axis_v.cast<double>();
  const Eigen::Vector3d product = a.cross(b);
  if (product.isZero(0.0)) return kernel.velocity;
  const Eigen::Vector3d normal = product.normalized();
  const double out = normal.dot(kernel.velocity);
  const double within = (kernel.velocity - out * normal).norm();
  const double length = least_motion_radii * std::sqrt(0.5 * (a.squaredNorm() + b.squaredNorm()));
  double least = least_motion_tangent * within;
  if (within < length) least = std::max(least, std::sqrt(length * length - within * within));
  if (std::abs(out) >= least) return kernel.velocity;
  return kernel.velocity + (std::copysign(least, out) - out) * normal;
}

}  // namespace swept
