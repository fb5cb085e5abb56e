// How far apart the rims of two discs are on the film. Private to splat.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace swept {

/// A disc's axes in camera space.
struct DiscAxes {
  Eigen::Vector3d u, v;
};

/// Wasserstein's distance of the two discs' ellipses on the film, and what their rims are apart along the
/// ray, which is seen where surfaces meet: px, 0 for discs that are the same but for a turn within their own
/// plane. Both centres at (x, y, 1) times their depth, at which a unit has `scale` px. Widened by the pixel
/// filter ellipses would be nearer, but small discs that are cut by that come out worse.
[[nodiscard]] inline double rims_apart_px(const DiscAxes& a, const DiscAxes& b, double x, double y,
                                          double scale) {
  struct Ellipse {
    double xx, xy, yy;
    [[nodiscard]] double trace() const { return xx + yy; }
    [[nodiscard]] double determinant() const { return std::max(0.0, xx * yy - xy * xy); }
  };
  const auto ellipse = [&](const DiscAxes& disc) {
    const double ux = scale * (disc.u.x() - x * disc.u.z()), uy = scale * (disc.u.y() - y * disc.u.z());
    const double vx = scale * (disc.v.x() - x * disc.v.z()), vy = scale * (disc.v.y() - y * disc.v.z());
    return Ellipse{ux * ux + vx * vx, ux * uy + vx * vy, uy * uy + vy * vy};
  };
  const Ellipse p = ellipse(a), q = ellipse(b);
  // Of P + Q − 2 (P^½ Q P^½)^½ the trace; that of the root of a 2 × 2 matrix follows from its trace and
  // determinant.
  const double product = p.xx * q.xx + 2.0 * p.xy * q.xy + p.yy * q.yy;
  const double root = std::sqrt(product + 2.0 * std::sqrt(p.determinant() * q.determinant()));
  const double on_film = std::max(0.0, p.trace() + q.trace() - 2.0 * root);
  // The turn that brings them nearest, as align_axes() has it.
  const double cosine = a.u.dot(b.u) + a.v.dot(b.v), sine = a.v.dot(b.u) - a.u.dot(b.v);
  const double length = std::hypot(cosine, sine);
  const double c = length > 0.0 ? cosine / length : 1.0, s = length > 0.0 ? sine / length : 0.0;
  const double along =
      scale * std::hypot(c * a.u.z() + s * a.v.z() - b.u.z(), c * a.v.z() - s * a.u.z() - b.v.z());
  return std::sqrt(on_film + along * along);
}

}  // namespace swept
