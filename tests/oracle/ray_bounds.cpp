#include "tests/oracle/ray_bounds.h"

namespace swept::oracle {

CoordinateBounds coordinate_bounds(const MovingKernel& kernel, double x, double y, const Ray& exact,
                                   double unit) {
  using Eigen::Vector3d;
  // Scaled as the axes are, for their squares to be in range.
  const double scale =
      1.0 / std::max<double>(kernel.axis_u.cwiseAbs().maxCoeff(), kernel.axis_v.cwiseAbs().maxCoeff());
  const Vector3d a = scale * kernel.axis_u.cast<double>(), b = scale * kernel.axis_v.cast<double>();
  const Vector3d &c = kernel.center, &m = kernel.velocity, d(x, y, 1.0);
  const Vector3d n = a.cross(b);
  const double length = std::max(a.norm(), b.norm());
  const double sum = n.cwiseAbs().dot(d.cwiseAbs()), facing = std::abs(n.dot(d));
  const bool from_center = std::max(std::abs(c.x()), std::abs(c.y())) < 0x1p20 * c.z();
  const double offset = from_center ? std::abs(x - c.x() / c.z()) + std::abs(y - c.y() / c.z())
                                    : std::abs(x) + std::abs(y) + 1.0;
  const double shared = (4 * sum + 2 * facing) * unit / facing;
  // A centre moved by ε|c| moves (u, v) by as much over the disc's radius along the ray.
  const double moved = length * c.norm() * (std::abs(x) + std::abs(y) + 1.0) * scale * unit / facing;
  const double center_part = 5 * length * c.norm() * offset * scale * unit / facing + moved;
  const double rate_part = 6 * length * m.norm() * (std::abs(x) + std::abs(y) + 1.0) * scale * unit / facing;
  return {center_part + std::abs(exact.u.high) * shared,
          center_part + std::abs(exact.v.high) * shared,
          4 * n.norm() * c.norm() * unit / facing + std::abs(exact.z.high) * shared,
          rate_part + std::abs(exact.du.high) * shared,
          rate_part + std::abs(exact.dv.high) * shared,
          4 * n.norm() * m.norm() * unit / facing + std::abs(exact.dz.high) * shared};
}

double coordinate_error(const MovingKernel& kernel, double x, double y,
                        const RayCoordinates<double>& computed, double unit) {
  const Ray exact = along(kernel, x, y);
  if (in_plane(exact, unit)) return std::numeric_limits<double>::quiet_NaN();
  const CoordinateBounds bounds = coordinate_bounds(kernel, x, y, exact, unit);
  const auto share = [](double value, Exact of, double bound) {
    const double off = error(value, of);
    return off == 0.0 ? 0.0 : off / bound;
  };
  double worst = 0.0;
  for (const double ratio :
       {share(computed.u, exact.u, bounds.u), share(computed.v, exact.v, bounds.v),
        share(computed.z, exact.z, bounds.z), share(computed.du, exact.du, bounds.du),
        share(computed.dv, exact.dv, bounds.dv), share(computed.dz, exact.dz, bounds.dz)})
    if (!(ratio <= worst)) worst = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio;
  return worst;
}

}  // namespace swept::oracle
