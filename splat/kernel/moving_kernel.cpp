// Pixel filter of a disc. Sources and derivation: moving_kernel.h.
#include "splat/kernel/moving_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "splat/kernel/ray_kernel.h"

namespace swept {
namespace {

double rms_radius(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::sqrt(0.5 * (a.squaredNorm() + b.squaredNorm()));
}

/// Cosine, not negative, and sine of half the angle of (x, y): by roots, which round alike everywhere.
std::pair<double, double> half_angle(double x, double y) {
  const double length = length_of(x, y);
  if (!(length > 0.0)) return {1.0, 0.0};
  // The larger of the two by the root, the other by what their product is: no difference of near equals.
  const double larger = std::sqrt(0.5 * (1.0 + std::abs(x) / length));
  const double other = 0.5 * (std::abs(y) / length) / larger;
  return x >= 0.0 ? std::pair(larger, std::copysign(other, y)) : std::pair(other, std::copysign(larger, y));
}

FilteredDisc filter_scaled_disc(const Eigen::Vector2d& tangent, const Eigen::Vector3d& axis_u,
                                const Eigen::Vector3d& axis_v, double radius) {
  FilteredDisc disc;
  if (radius == 0.0) {
    disc = {axis_u, axis_v, 1.0, rms_radius(axis_u, axis_v)};
    if (axis_u.cross(axis_v).isZero(0.0)) disc.weight = 0.0;
    return disc;
  }

  const Eigen::Vector2d q_u = axis_u.head<2>() - tangent * axis_u.z();
  const Eigen::Vector2d q_v = axis_v.head<2>() - tangent * axis_v.z();

  // One Jacobi rotation in (u, v) makes the columns of Q orthogonal: Q = Σ sᵢ lᵢ rᵢᵀ.
  const auto [cosine, sine] = half_angle(q_u.squaredNorm() - q_v.squaredNorm(), 2.0 * q_u.dot(q_v));
  const Eigen::Vector2d major = cosine * q_u + sine * q_v;
  const double s_major = major.norm();
  const Eigen::Vector2d l_major =
      s_major > 0.0 ? Eigen::Vector2d(major / s_major) : Eigen::Vector2d(1.0, 0.0);
  const Eigen::Vector2d l_minor(-l_major.y(), l_major.x());
  // Signed, so that an edge-on disc passes through zero; from the determinant, which keeps its digits there.
  const double s_minor = s_major > 0.0 ? (q_u.x() * q_v.y() - q_u.y() * q_v.x()) / s_major : 0.0;

  double size_squared = 0.0;
  const auto lift = [&](const Eigen::Vector2d& direction, double s, double disc_z) {
    const double filtered = length_of(s, radius);
    const double z = s / filtered * disc_z;
    // Of a radius too small for a quarter of it the least normal number has to do.
    const double shown = std::max({std::abs(s), 0.25 * radius, std::numeric_limits<double>::min()});
    const double own_plane_z = filtered / shown * disc_z;
    size_squared += 0.5 * (filtered * filtered + own_plane_z * own_plane_z);
    const Eigen::Vector2d xy = direction * filtered + tangent * z;
    return Eigen::Vector3d(xy.x(), xy.y(), z);
  };
  disc.axis_u = lift(l_major, s_major, cosine * axis_u.z() + sine * axis_v.z());
  disc.axis_v = lift(l_minor, s_minor, cosine * axis_v.z() - sine * axis_u.z());
  disc.weight = s_major / length_of(s_major, radius) * (std::abs(s_minor) / length_of(s_minor, radius));
  disc.size = std::sqrt(size_squared);
  return disc;
}

}  // namespace

FilteredDisc filter_disc(const Eigen::Vector3d& center, const Eigen::Vector3d& axis_u,
                         const Eigen::Vector3d& axis_v, const PixelFilter& filter) {
  const double depth = filter.orthographic ? 1.0 : std::max(center.z(), filter.near);
  const double radius = filter.radius * depth;
  Eigen::Vector2d tangent(std::clamp(center.x() / depth, -filter.max_tangent_x, filter.max_tangent_x),
                          std::clamp(center.y() / depth, -filter.max_tangent_y, filter.max_tangent_y));
  if (filter.orthographic) tangent.setZero();
  // Lengths about 1, for their squares and products to stay in range: by a power of two, itself in range both
  // ways, which changes no bit otherwise.
  int power = 0;
  std::frexp(std::max({axis_u.cwiseAbs().maxCoeff(), axis_v.cwiseAbs().maxCoeff(), radius}), &power);
  power = std::clamp(power, -1000, 1000);
  const double unit = std::ldexp(1.0, power), per_unit = std::ldexp(1.0, -power);
  FilteredDisc disc = filter_scaled_disc(tangent, per_unit * axis_u, per_unit * axis_v, per_unit * radius);
  disc.axis_u *= unit;
  disc.axis_v *= unit;
  disc.size *= unit;
  return disc;
}

}  // namespace swept
