// A moving kernel seen along one viewing ray: the stretch of time it covers the pixel, its Gaussian in
// time, and its depth.
//
// Source: model section 2; Heinzle et al. 2010, Eq. 15 to 21, without the matrix inverse. Along a ray the
// disc's coordinates (u, v) run along a straight line at constant speed. So the kernel is a Gaussian in
// time, peak · exp(−(y_begin + rate·(τ − t_begin))²), cut where that line leaves the unit circle.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "splat/moving_kernel.h"

namespace swept {

/// Coordinates in the disc's plane and depth along one ray, linear in the time from the segment's middle:
/// u + du·(τ − t_mid) and so on. Not finite where the ray lies in the disc's plane.
template <class T>
struct RayCoordinates {
  T u, v, z;
  T du, dv, dz;
};

/// What of a kernel does not depend on the ray. With n = a₁ × a₂ and d = (x, y, 1)
///
///   u = d·(a₂ × c) / d·n,   v = d·(c × a₁) / d·n,   z = n·c / d·n,
///
/// and the same with m for c gives the rates. The products d·(a₂ × c) cancel where the disc is small and far
/// away. Taken at the ray through the centre, d = (c_xy/c_z, 1), they are zero; so they are evaluated from
/// there.
template <class T>
class KernelPlane {
 public:
  using Vector3 = Eigen::Matrix<T, 3, 1>;

  explicit KernelPlane(const MovingKernel& kernel) {
    const Vector3 c = kernel.center.cast<T>(), m = kernel.velocity.cast<T>();
    // A common factor of the axes' product cancels; scaling it to 1 keeps tiny and huge discs in range.
    const Vector3 a = kernel.axis_u.cast<T>(), b = kernel.axis_v.cast<T>();
    const T scale = T(1) / (std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()));
    const Vector3 as = a * scale, bs = b * scale;
    normal_ = as.cross(bs);
    u_ = bs.cross(c) * scale;
    v_ = c.cross(as) * scale;
    du_ = bs.cross(m) * scale;
    dv_ = m.cross(as) * scale;
    z_ = normal_.dot(c);
    dz_ = normal_.dot(m);
    facing_ = kernel.facing.cast<T>();
    if (c.z() > T(0)) {
      center_x_ = c.x() / c.z();
      center_y_ = c.y() / c.z();
    } else {
      u_center_ = u_.z();
      v_center_ = v_.z();
    }
  }

  /// Whether the disc shows this ray a side it may be seen from.
  [[nodiscard]] bool faces(T x, T y) const {
    return !(facing_.x() * x + facing_.y() * y + facing_.z() >= T(0)) || facing_.isZero(T(0));
  }

  /// For the ray (x, y, 1), x and y being tangents.
  [[nodiscard]] RayCoordinates<T> along(T x, T y) const {
    const T inverse = T(1) / (normal_.x() * x + normal_.y() * y + normal_.z());
    const T from_x = x - center_x_, from_y = y - center_y_;
    return {(u_.x() * from_x + u_.y() * from_y + u_center_) * inverse,
            (v_.x() * from_x + v_.y() * from_y + v_center_) * inverse,
            z_ * inverse,
            (du_.x() * x + du_.y() * y + du_.z()) * inverse,
            (dv_.x() * x + dv_.y() * y + dv_.z()) * inverse,
            dz_ * inverse};
  }

 private:
  Vector3 normal_, u_, v_, du_, dv_, facing_;
  T z_, dz_;
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

/// Tube ∩ segment ∩ in front of the near plane. Returns false if that is empty. Never a NaN from finite
/// coordinates; coordinates that are not finite are a miss.
template <class T>
[[nodiscard]] bool intersect_tube(const RayCoordinates<T>& ray, T segment_begin, T segment_end, T near,
                                  T delta, T weight, RayFragment<T>& fragment) {
  const T t_mid = T(0.5) * (segment_begin + segment_end);
  T begin = segment_begin, end = segment_end;
  T position = T(0), nearest_squared;  // along the line at `begin`, from the point nearest the disc's centre
  const T speed = std::hypot(ray.du, ray.dv);
  if (speed > T(0)) {
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
  return true;
}

}  // namespace swept
