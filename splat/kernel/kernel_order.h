// The order of kernels, which depends on their content alone. Private to splat and the A-buffer.
#pragma once

#include <cstdint>
#include <limits>

#include "splat/export.h"
#include "splat/kernel/moving_kernel.h"

namespace SWEPT_API swept {

/// Along a space-filling curve through the box of all kernels' centres, for locality; within a cell of it by
/// content. Identical kernels are interchangeable, so the order does not depend on that which came in.
class KernelOrder {
 public:
  /// Of a kernel of the scene; all of them before any key is asked for.
  void include(const MovingKernel& kernel) {
    low_ = low_.cwiseMin(kernel.center);
    high_ = high_.cwiseMax(kernel.center);
  }
  [[nodiscard]] std::uint64_t key(const MovingKernel& kernel) const;
  /// For kernels of equal keys.
  [[nodiscard]] static bool content_less(const MovingKernel& a, const MovingKernel& b);

 private:
  Eigen::Vector3d low_ = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high_ = -low_;
};

}  // namespace swept
