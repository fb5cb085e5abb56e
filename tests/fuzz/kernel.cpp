// Fuzzes the kernel's formulas: the integral over time, the pixel filter, and the fragment that a ray meets.
// No finite input makes a NaN or an infinity, and results stay where the headers promise.
#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/kernel/kernel_integral.h"
#include "splat/kernel/ray_kernel.h"
#include "tests/fuzz/check.h"

namespace swept {
namespace {

using fuzz::Bytes;

template <class T>
constexpr T unit_roundoff = std::numeric_limits<T>::epsilon() / 2;

/// Mean of exp(−y²): range, symmetry, and parts that sum to the whole.
template <class T>
void check_mean(T a, T b) {
  if (a > b) std::swap(a, b);
  const T mean = mean_gaussian(a, b);
  SWEPT_HOLDS(mean >= T(0) && mean <= T(1));
  SWEPT_HOLDS(mean == mean_gaussian(-b, -a));
  // The mean lies between the extremes of exp(−y²), each within 4 ulp; subnormal ones within as many steps.
  const T nearest = a <= T(0) && b >= T(0) ? T(0) : std::min(std::abs(a), std::abs(b));
  const T step = 4 * std::numeric_limits<T>::denorm_min();
  SWEPT_HOLDS(mean <= mean_gaussian(nearest, nearest) * (1 + 16 * unit_roundoff<T>)+step);

  const T middle = a / 2 + b / 2, length = b - a;
  if (!(a < middle && middle < b) || !std::isfinite(length)) return;
  // Each side within 4 ulp, 8 roundoffs; the lengths are rounded once each, and the products and the sum.
  const T left = (middle - a) * mean_gaussian(a, middle), right = (b - middle) * mean_gaussian(middle, b);
  const T whole = length * mean;
  const T bound = (2 * 8 + 6) * unit_roundoff<T> * (left + right) + (length + 4) * step;
  if (std::isfinite(bound)) SWEPT_HOLDS(std::abs(left + right - whole) <= bound);
}

Eigen::Vector3d vector(Bytes& bytes) {
  const double x = bytes.real(), y = bytes.real();
  return {x, y, bytes.real()};
}

Eigen::Vector3f float_vector(Bytes& bytes) {
  const float x = bytes.real_float(), y = bytes.real_float();
  return {x, y, bytes.real_float()};
}

template <class T>
void check_fragment(const RayCoordinates<T>& ray, T begin, T end, T near, T delta, T weight) {
  RayFragment<T> f;
  if (!intersect_tube(ray, begin, end, near, delta, weight, f)) return;
  SWEPT_HOLDS(begin <= f.t_begin && f.t_begin < f.t_end && f.t_end <= end);
  SWEPT_HOLDS(f.peak >= T(0) && f.peak <= weight);
  SWEPT_HOLDS(f.rate >= T(0) && std::isfinite(f.rate));
  SWEPT_HOLDS(std::isfinite(f.y_begin) && std::isfinite(f.z_begin) && std::isfinite(f.z_rate));
  const T y_end = f.y_begin + f.rate * (f.t_end - f.t_begin);
  if (std::isfinite(y_end)) {
    const T integral = interval_integral(f.peak, f.t_end - f.t_begin, f.y_begin, std::max(f.y_begin, y_end));
    SWEPT_HOLDS(integral >= T(0) && integral <= f.peak * (f.t_end - f.t_begin) * (1 + 8 * unit_roundoff<T>));
  }
  // What the header says of the depth at t_begin, which is the near plane's or beyond it.
  const T bound = 8 * unit_roundoff<T> * (std::abs(ray.z) + near + std::abs(ray.dz));
  if (std::isfinite(bound)) SWEPT_HOLDS(f.z_begin >= near - bound);
}

void check_ray(Bytes& bytes) {
  MovingKernel kernel;
  kernel.center = vector(bytes);
  kernel.velocity = vector(bytes);
  kernel.axis_u = float_vector(bytes);
  kernel.axis_v = float_vector(bytes);
  kernel.facing = float_vector(bytes);
  const double x = bytes.real(), y = bytes.real(), near = std::max(std::abs(bytes.real()), 1e-300);
  const double delta = std::max(50.0 * bytes.unit(), 1e-3), weight = bytes.unit();
  const double middle = bytes.unit(), begin = middle * bytes.unit(),
               end = middle + (1.0 - middle) * bytes.unit();
  if (!(begin < end)) return;
  check_fragment(KernelPlane<double>(kernel).along(x, y), begin, end, near, delta, weight);
  const float float_begin = static_cast<float>(begin), float_end = static_cast<float>(end);
  const float float_near = static_cast<float>(std::clamp(near, 1e-37, 1e37));
  if (!(float_begin < float_end) || std::max(std::abs(x), std::abs(y)) > 1e37) return;
  check_fragment(KernelPlane<float>(kernel).along(static_cast<float>(x), static_cast<float>(y)), float_begin,
                 float_end, float_near, static_cast<float>(delta), static_cast<float>(weight));
}

/// As a scene's discs come: axes in the range of float.
void check_filter(Bytes& bytes) {
  const Eigen::Vector3d center = vector(bytes), u = float_vector(bytes).cast<double>(),
                        v = float_vector(bytes).cast<double>();
  PixelFilter filter;
  filter.radius = bytes.unit() * (bytes.flag() ? 1.0 : 1e-3);
  filter.max_tangent_x = 1e-3 + 4.0 * bytes.unit();
  filter.max_tangent_y = 1e-3 + 4.0 * bytes.unit();
  filter.near = std::max(std::abs(bytes.real()), 1e-300);
  const FilteredDisc disc = filter_disc(center, u, v, filter);
  SWEPT_HOLDS(disc.weight >= 0.0 && disc.weight <= 1.0);
  // The filter's radius is a length at the disc's depth, and sums of squares of either may be out of range.
  if (center.cwiseAbs().maxCoeff() > 1e150 || filter.near > 1e150) return;
  SWEPT_HOLDS(disc.axis_u.allFinite() && disc.axis_v.allFinite());
  SWEPT_HOLDS(disc.size >= 0.0 && std::isfinite(disc.size));
}

}  // namespace
}  // namespace swept

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  swept::fuzz::Bytes bytes(data, size);
  switch (bytes.below(4)) {
    case 0: {
      const double a = bytes.real(), b = bytes.real();
      swept::check_mean(a, b);
      break;
    }
    case 1: {
      const float a = bytes.real_float(), b = bytes.real_float();
      swept::check_mean(a, b);
      break;
    }
    case 2:
      swept::check_filter(bytes);
      break;
    default:
      swept::check_ray(bytes);
  }
  return 0;
}
