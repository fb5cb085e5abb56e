// A moving kernel seen along one viewing ray: the interval in which it covers the pixel, its Gaussian in
// time, and its depth.
//
// Source: model section 2; Heinzle et al. 2010, Eq. 15 to 21, without the matrix inverse. Along a ray the
// disc's coordinates (u, v) run along a straight line at constant speed. So the kernel is a Gaussian in
// time, peak · exp(−(y_begin + rate·(τ − t_begin))²), cut where that line leaves the unit circle.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "splat/export.h"
#include "splat/kernel/moving_kernel.h"

namespace SWEPT_API swept {

/// Coordinates in the disc's plane and depth along one ray, linear in the time from the segment's middle:
/// u + du·(τ − t_mid) and so on. They need not be finite where the ray lies in the disc's plane to
/// rounding.
template <class T>
struct RayCoordinates {
  T u, v, z;
  T du, dv, dz;
};

/// The part of a kernel that does not depend on the ray. With n = a₁ × a₂ and d = (x, y, 1)
///
///   u = d·(a₂ × c) / d·n,   v = d·(c × a₁) / d·n,   z = n·c / d·n,
///
/// and the same with m for c gives the rates. The products d·(a₂ × c) cancel where the disc is small and far
/// away. Taken at the ray through the centre, d = (c_xy/c_z, 1), they are zero; so they are evaluated from
/// there.
///
/// Powers of two common to the axes, and to c and m, are taken out before anything is multiplied: no product
/// overflows or underflows, and scaling a scene by a power of two changes no bit of (u, v).
///
/// Rounding errors of `along`, with ε the unit roundoff of T, |a| the larger of |a₁| and |a₂|, and N =
/// Σ|nᵢdᵢ|, which is |n·d| but for cancellation near edge-on. (u, v) are those of a centre moved by ε|c| and
///   |Δu| ≤ ε (5 |a||c| (|x − c_x/c_z| + |y − c_y/c_z|) + |u| (4N + 2|n·d|)) / |n·d|,
///   |Δdu| ≤ ε (6 |a||m| (|x| + |y| + 1) + |du| (4N + 2|n·d|)) / |n·d|,
///   |Δz| ≤ ε (4 |n||c| + |z| (4N + 2|n·d|)) / |n·d|,   |Δdz| the same with m for c.
///
/// An orthographic camera's rays are parallel, (x, y, z) for all z. Across them the disc is what a pinhole
/// sees of its shadow (c_x, c_y, 1) with axes (a_x, a_y, 0), so that u, v and their rates are as above with n
/// = (0, 0, n_z); and its depth is z = (n·c − n_x x − n_y y) / n_z.
template <class T>
class KernelPlane {
 public:
  using Vector3 = Eigen::Matrix<T, 3, 1>;

  /// Computed in double whatever T is: the axes' product is then exact but for one rounding.
  explicit KernelPlane(const MovingKernel& kernel, bool orthographic = false) {
    using Eigen::Vector3d;
    const int axis_exponent =
        exponent(std::max<double>(kernel.axis_u.cwiseAbs().maxCoeff(), kernel.axis_v.cwiseAbs().maxCoeff()));
    const int length_exponent =
        exponent(std::max(kernel.center.cwiseAbs().maxCoeff(), kernel.velocity.cwiseAbs().maxCoeff()));
    const double axis_unit = power_of_two(-axis_exponent), length_unit = power_of_two(-length_exponent);
    const Vector3d a = axis_unit * kernel.axis_u.cast<double>(), b = axis_unit * kernel.axis_v.cast<double>();
    const Vector3d c = length_unit * kernel.center, m = length_unit * kernel.velocity;
    const Vector3d n = a.cross(b);
    if (orthographic) {
      set_parallel(kernel, a, b, axis_exponent);
      return;
    }
    const double lengths_per_axis = power_of_two(length_exponent - axis_exponent);
    normal_ = n.cast<T>();
    u_ = in_range(lengths_per_axis * b.cross(c));
    v_ = in_range(lengths_per_axis * c.cross(a));
    du_ = in_range(lengths_per_axis * b.cross(m));
    dv_ = in_range(lengths_per_axis * m.cross(a));
    const Vector3 depths = in_range(power_of_two(length_exponent) * Vector3d(n.dot(c), n.dot(m), 0.0));
    z_ = depths.x();
    dz_ = depths.y();
    facing_ = kernel.facing.cast<T>();
    outside_ = kernel.outside.cast<T>();
    oriented_ = !kernel.outside.isZero(0.0f);
    // Not for a centre beside the eye, whose ray is no better than any other.
    constexpr double widest_tangent = 0x1p20;
    if (std::max(std::abs(c.x()), std::abs(c.y())) < widest_tangent * c.z()) {
      center_x_ = static_cast<T>(c.x() / c.z());
      center_y_ = static_cast<T>(c.y() / c.z());
    } else {
      u_center_ = u_.z();
      v_center_ = v_.z();
    }
  }

  /// Whether the disc may be seen from the side that it shows this ray.
  [[nodiscard]] bool faces(T x, T y) const {
    return !(facing_.x() * x + facing_.y() * y + facing_.z() >= T(0)) || facing_.isZero(T(0));
  }

  /// Whether the disc's front and back are told apart.
  [[nodiscard]] bool oriented() const { return oriented_; }
  /// Whether the disc, oriented, shows this ray its back.
  [[nodiscard]] bool shows_back(T x, T y) const {
    return !(outside_.x() * x + outside_.y() * y + outside_.z() < T(0));
  }

  /// For the ray (x, y, 1), x and y being tangents; of an orthographic camera for the one from (x, y, 0).
  [[nodiscard]] RayCoordinates<T> along(T x, T y) const {
    const T inverse = T(1) / (normal_.x() * x + normal_.y() * y + normal_.z());
    const T from_x = x - center_x_, from_y = y - center_y_;
    return {(u_.x() * from_x + u_.y() * from_y + u_center_) * inverse,
            (v_.x() * from_x + v_.y() * from_y + v_center_) * inverse,
            (z_ - (z_x_ * from_x + z_y_ * from_y)) * inverse,
            (du_.x() * x + du_.y() * y + du_.z()) * inverse,
            (dv_.x() * x + dv_.y() * y + dv_.z()) * inverse,
            dz_ * inverse};
  }

 private:
  /// Of an orthographic camera; `a` and `b` are the axes less their power of two.
  void set_parallel(const MovingKernel& kernel, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    int axis_exponent) {
    using Eigen::Vector3d;
    const Vector3d n = a.cross(b), c = kernel.center, m = kernel.velocity;
    const double per_axis = power_of_two(-axis_exponent);
    normal_ = Vector3d(0.0, 0.0, n.z()).cast<T>();
    u_ = in_range(per_axis * Vector3d(b.y(), -b.x(), 0.0));
    v_ = in_range(per_axis * Vector3d(-a.y(), a.x(), 0.0));
    du_ = in_range(per_axis * Vector3d(0.0, 0.0, b.x() * m.y() - b.y() * m.x()));
    dv_ = in_range(per_axis * Vector3d(0.0, 0.0, m.x() * a.y() - m.y() * a.x()));
    const Vector3 depths = in_range(Vector3d(n.z() * c.z(), n.dot(m), 0.0));
    z_ = depths.x();
    dz_ = depths.y();
    z_x_ = static_cast<T>(n.x());
    z_y_ = static_cast<T>(n.y());
    const Vector3 center = in_range(c);
    center_x_ = center.x();
    center_y_ = center.y();
    // Seen exactly edge-on a side is turned away, as one that is seen at all is not.
    const auto along_ray = [](const Eigen::Vector3f& outside) {
      const bool known = !outside.isZero(0.0f);
      return Vector3(T(0), T(0), known && outside.z() == 0.0f ? T(1) : static_cast<T>(outside.z()));
    };
    facing_ = along_ray(kernel.facing);
    outside_ = along_ray(kernel.outside);
    oriented_ = !kernel.outside.isZero(0.0f);
  }
  /// e with 2^(e−1) ≤ largest < 2^e, within ±1000: powers of two are then normal numbers, and what is beyond
  /// is in range all the same when they are taken out.
  static int exponent(double largest) {
    return std::clamp(static_cast<int>(std::bit_cast<std::uint64_t>(largest) >> 52) - 1022, -1000, 1000);
  }
  static double power_of_two(int power) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(std::clamp(power, -1000, 1000) + 1023) << 52);
  }
  /// What is beyond T's range is far outside the disc, and stays there.
  static Vector3 in_range(const Eigen::Vector3d& v) {
    constexpr double largest = std::numeric_limits<T>::max();
    return v.cwiseMax(-largest).cwiseMin(largest).template cast<T>();
  }

  Vector3 normal_, u_, v_, du_, dv_, facing_, outside_;
  bool oriented_;
  T z_, dz_;
  T z_x_ = T(0), z_y_ = T(0);            ///< of an orthographic camera
  T center_x_ = T(0), center_y_ = T(0);  ///< the ray from which (u, v) are evaluated
  T u_center_ = T(0), v_center_ = T(0);  ///< their numerators there
};

/// A fragment: the interval in which a kernel covers a pixel centre, at or beyond the near plane.
template <class T>
struct RayFragment {
  T t_begin, t_end;  ///< shutter time, t_begin < t_end
  T peak;            ///< the kernel's value where the line passes nearest the disc's centre
  T y_begin, rate;  ///< ρ(τ) = peak · exp(−(y_begin + rate·(τ − t_begin))²); rate ≥ 0, 0: constant
  T z_begin, z_rate;  ///< camera-space depth at t_begin, and its change per unit of τ
};

/// √(a² + b²) within 2 ε, by operations that round alike everywhere; beyond their range by the library's.
template <class T>
[[nodiscard]] T length_of(T a, T b) {
  constexpr T lowest = std::numeric_limits<T>::min() / std::numeric_limits<T>::epsilon();
  const T square = a * a + b * b;
  return square >= lowest && square <= std::numeric_limits<T>::max() ? std::sqrt(square) : std::hypot(a, b);
}

/// Tube ∩ segment ∩ in front of the near plane. Returns false if that is empty. Never a NaN and never an
/// infinity: coordinates that are not finite, or whose fragment would not be, are a miss.
///
/// Backward stable. With ε the unit roundoff of T, w = |(u, v)|, s = |(du, dv)| and times in [0, 1], each of
/// t_begin and t_end is exact for coordinates (u, v) moved by at most 16 ε (1 + w + s), or where it is the
/// near plane's, for a depth moved by 4 ε (|z| + near + |dz|). The same holds for a tube missed or grazed. At
/// the returned t_begin, y_begin is off by at most 24 ε √δ (1 + w + s), z_begin by 4 ε (|z| + |dz|), and peak
/// is within ε (2 δ + 3) of that for (u, v) moved by 5 ε w.
///   Why: the direction is within 3 ε, so along and across are within 5 ε w (products, sums, and
///   Cauchy-Schwarz); the half chord is within 2.5 ε of what belongs to that across, and the quotient adds
///   4 ε (1 + w) and ε s for the time's own rounding. The distance from the centre is across² + along², whose
///   derivatives by either are at most 1, so these add up, also where the tube is tangent.
template <class T>
[[nodiscard]] bool intersect_tube(const RayCoordinates<T>& ray, T segment_begin, T segment_end, T near,
                                  T delta, T weight, RayFragment<T>& fragment) {
  const T t_mid = T(0.5) * (segment_begin + segment_end);
  T begin = segment_begin, end = segment_end;
  T position = T(0), nearest_squared;  // along the line at `begin`, from the point nearest the disc's centre
  T speed = length_of(ray.du, ray.dv);
  // Below the normal numbers a direction has no digits left, and nothing moves. Written so that NaN, which
  // then fails the comparison of nearest_squared, does not pass for still.
  if (!(speed < std::numeric_limits<T>::min())) {
    // Along the line, and across it by the cross product: no difference of squares.
    const T direction_u = ray.du / speed, direction_v = ray.dv / speed;
    const T across = ray.u * direction_v - ray.v * direction_u;
    const T along = ray.u * direction_u + ray.v * direction_v;
    nearest_squared = across * across;
    if (!(nearest_squared <= T(1))) return false;
    const T half_chord = std::sqrt((T(1) - across) * (T(1) + across));
    const T entry = t_mid + (-half_chord - along) / speed;
    if (entry > begin) {
      begin = entry;
      position = -half_chord;
    } else {
      position = along + speed * (begin - t_mid);
    }
    end = std::min(end, t_mid + (half_chord - along) / speed);
  } else {
    speed = T(0);
    nearest_squared = ray.u * ray.u + ray.v * ray.v;
    if (!(nearest_squared <= T(1))) return false;
  }
  if (ray.dz != T(0)) {
    const T crossing = t_mid + (near - ray.z) / ray.dz;
    if (ray.dz < T(0)) {
      end = std::min(end, crossing);
    } else if (crossing > begin) {
      position += speed * (crossing - begin);
      begin = crossing;
    }
  } else if (!(ray.z >= near)) {
    return false;
  }
  if (!(begin < end)) return false;

  const T root_delta = std::sqrt(delta);
  fragment.t_begin = begin;
  fragment.t_end = end;
  fragment.peak = weight * std::exp(-delta * nearest_squared);
  fragment.rate = root_delta * speed;
  fragment.y_begin = root_delta * position;
  fragment.z_begin = ray.z + ray.dz * (begin - t_mid);
  fragment.z_rate = ray.dz;
  // Not written as a sum, which might overflow where its parts do not.
  constexpr T largest = std::numeric_limits<T>::max();
  return std::abs(fragment.z_begin) <= largest && std::abs(fragment.z_rate) <= largest &&
         std::abs(fragment.y_begin) <= largest && fragment.rate <= largest;
}

}  // namespace swept
