// The formulas as one first writes them, to show what stability buys. Nothing renders with these.
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "splat/kernel/ray_kernel.h"

namespace swept::naive {

/// Heinzle et al. 2010, Eq. 18 to 20: a difference of erf.
template <class T>
[[nodiscard]] T mean_gaussian(T y_begin, T y_end) {
  return T(0.5) / std::numbers::inv_sqrtpi_v<T> * (std::erf(y_end) - std::erf(y_begin)) / (y_end - y_begin);
}

/// Where in [y_begin, y_end] exp(−y²) has its weight, from the middle in units of the span, by the two
/// integrals.
[[nodiscard]] inline double gaussian_centroid(double y_begin, double y_end) {
  const double span = y_end - y_begin, mean = mean_gaussian(y_begin, y_end);
  const double first = (std::exp(-y_begin * y_begin) - std::exp(-y_end * y_end)) / (2.0 * span);
  return (first / mean - 0.5 * (y_begin + y_end)) / span;
}

/// The tube by the textbook quadratic, the peak by (b·b)(f·f) − (b·f)², time measured from the segment's
/// middle.
template <class T>
[[nodiscard]] bool intersect_tube(const RayCoordinates<T>& ray, T segment_begin, T segment_end, T near,
                                  T delta, T weight, RayFragment<T>& fragment) {
  const T t_mid = T(0.5) * (segment_begin + segment_end);
  const T a = ray.du * ray.du + ray.dv * ray.dv;
  const T b = T(2) * (ray.u * ray.du + ray.v * ray.dv);
  const T c = ray.u * ray.u + ray.v * ray.v - T(1);
  const T discriminant = b * b - T(4) * a * c;
  if (!(discriminant >= T(0))) return false;
  const T root = std::sqrt(discriminant);
  T begin = std::max(segment_begin, t_mid + (-b - root) / (T(2) * a));
  T end = std::min(segment_end, t_mid + (-b + root) / (T(2) * a));
  const T crossing = t_mid + (near - ray.z) / ray.dz;
  if (ray.dz > T(0)) begin = std::max(begin, crossing);
  if (ray.dz < T(0)) end = std::min(end, crossing);
  if (!(begin < end)) return false;
  const T across_squared =
      ((ray.u * ray.u + ray.v * ray.v) * a - T(0.25) * b * b) / a;  // (b·b)(f·f) − (b·f)²
  fragment.t_begin = begin;
  fragment.t_end = end;
  fragment.peak = weight * std::exp(-delta * across_squared);
  fragment.rate = std::sqrt(delta * a);
  fragment.y_begin = fragment.rate * (begin - t_mid) + std::sqrt(delta / a) * T(0.5) * b;
  fragment.z_begin = ray.z + ray.dz * (begin - t_mid);
  fragment.z_rate = ray.dz;
  return true;
}

/// Heinzle et al. 2010, Eq. 15 to 17: the ray taken into the frame T = [a₁ a₂ m c] by T⁻¹. The third
/// coordinate is time from the segment's middle, along which u, v and the depth are then linear. Not finite
/// for motion within the disc's plane.
template <class T>
[[nodiscard]] RayCoordinates<T> along(const MovingKernel& kernel, T x, T y) {
  Eigen::Matrix<T, 4, 4> frame = Eigen::Matrix<T, 4, 4>::Identity();
  frame.template block<3, 1>(0, 0) = kernel.axis_u.cast<T>();
  frame.template block<3, 1>(0, 1) = kernel.axis_v.cast<T>();
  frame.template block<3, 1>(0, 2) = kernel.velocity.cast<T>();
  frame.template block<3, 1>(0, 3) = kernel.center.cast<T>();
  const Eigen::Matrix<T, 4, 4> inverse = frame.inverse();
  const Eigen::Matrix<T, 4, 1> eye = inverse * Eigen::Matrix<T, 4, 1>(T(0), T(0), T(0), T(1));
  const Eigen::Matrix<T, 4, 1> ray = inverse * Eigen::Matrix<T, 4, 1>(x, y, T(1), T(0));
  // Ray parameter, which is the depth, as a function of time: eye_t + s ray_t = t.
  const T dz = T(1) / ray.z(), z = -eye.z() * dz;
  return {eye.x() + z * ray.x(), eye.y() + z * ray.y(), z, dz * ray.x(), dz * ray.y(), dz};
}

}  // namespace swept::naive
