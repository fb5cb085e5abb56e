#include "splat/kernel/kernel_order.h"

#include <array>

namespace swept {
namespace {

/// Spreads the low 21 bits of `v` to every third bit.
std::uint64_t every_third_bit(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

}  // namespace

std::uint64_t KernelOrder::key(const MovingKernel& kernel) const {
  // Of 2²¹ along each axis. Halves, and a quotient of differences: neither overflows.
  const auto cell = [&](int axis) {
    const double range = 0.5 * high_[axis] - 0.5 * low_[axis];
    const double place = range > 0.0 ? (0.5 * kernel.center[axis] - 0.5 * low_[axis]) / range : 0.0;
    return static_cast<std::uint64_t>(place * 0x1fffff);
  };
  return every_third_bit(cell(0)) | every_third_bit(cell(1)) << 1 | every_third_bit(cell(2)) << 2;
}

bool KernelOrder::content_less(const MovingKernel& a, const MovingKernel& b) {
  const auto content = [](const MovingKernel& k) {
    return std::array<double, 34>{
        k.center.x(),   k.center.y(),     k.center.z(),     k.velocity.x(),    k.velocity.y(),
        k.velocity.z(), k.axis_u.x(),     k.axis_u.y(),     k.axis_u.z(),      k.axis_v.x(),
        k.axis_v.y(),   k.axis_v.z(),     k.facing.x(),     k.facing.y(),      k.facing.z(),
        k.t_begin,      k.t_end,          k.weight,         k.depth_tolerance, k.color.x(),
        k.color.y(),    k.color.z(),      k.color.w(),      k.outside.x(),     k.outside.y(),
        k.outside.z(),  k.color_rate.x(), k.color_rate.y(), k.color_rate.z(),  k.color_rate.w(),
        k.bend.x(),     k.bend.y(),       k.bend.z(),       k.tolerance_rate};
  };
  return content(a) < content(b);
}

}  // namespace swept
