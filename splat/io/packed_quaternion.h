// Quaternions without their largest component, which unit length and a sign chosen for it give back.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

namespace swept::io {

/// The unit quaternion whose component `largest` was left out of `three`, the others in their order.
inline Eigen::Vector4d with_largest(const Eigen::Vector3d& three, std::size_t largest) {
  Eigen::Vector4d q;
  const auto left_out = static_cast<Eigen::Index>(largest);
  for (Eigen::Index k = 0, from = 0; k < 4; ++k) q[k] = k == left_out ? 0.0 : three[from++];
  q[left_out] = std::sqrt(std::max(0.0, 1.0 - three.squaredNorm()));
  return q;
}

}  // namespace swept::io
