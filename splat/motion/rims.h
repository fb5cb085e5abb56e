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

/// What rims may be off by where paths may be by 1: a chord's error is made good in the mean (build_kernels),
/// that of axes and filters that stand still is not.
inline constexpr double rims_per_path = 0.75;
/// What filters may be off by.
inline constexpr double filters_per_path = 0.6;

/// The outline of a disc, or of its cut-off, on the film: the matrix of its covariance, px².
struct FilmEllipse {
  double xx, xy, yy;

  /// Of a disc whose centre is at (x, y, 1) times its depth, at which a unit has `scale` px.
  FilmEllipse(const DiscAxes& disc, double x, double y, double scale) {
    const double ux = scale * (disc.u.x() - x * disc.u.z()), uy = scale * (disc.u.y() - y * disc.u.z());
    const double vx = scale * (disc.v.x() - x * disc.v.z()), vy = scale * (disc.v.y() - y * disc.v.z());
    xx = ux * ux + vx * vx;
    xy = ux * uy + vx * vy;
    yy = uy * uy + vy * vy;
  }
  [[nodiscard]] double trace() const { return xx + yy; }
  [[nodiscard]] double determinant() const { return std::max(0.0, xx * yy - xy * xy); }
};

/// Wasserstein's distance of the two discs' ellipses on the film, and what their rims are apart along the
/// ray, which is seen where surfaces meet: px, 0 for discs that are the same but for a turn within their own
/// plane. Both centres at (x, y, 1) times their depth, at which a unit has `scale` px. Widened by the pixel
/// filter ellipses would be nearer, but small discs that are cut by that come out worse.
[[nodiscard]] inline double rims_apart_px(const DiscAxes& a, const DiscAxes& b, double x, double y,
                                          double scale) {
  const FilmEllipse p(a, x, y, scale), q(b, x, y, scale);
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

/// How far the rims of a disc are apart, Wasserstein's distance again, with pixel filters of two radii, of
/// the disc's units.
[[nodiscard]] inline double filters_apart_px(const DiscAxes& disc, double x, double y, double scale,
                                             double radius_a, double radius_b) {
  const FilmEllipse ellipse(disc, x, y, scale);
  const double half = 0.5 * ellipse.trace();
  const double apart = std::sqrt(std::max(0.0, half * half - ellipse.determinant()));
  const double a = scale * radius_a, b = scale * radius_b;
  const auto widened = [&](double squared) {
    return std::sqrt(squared + a * a) - std::sqrt(squared + b * b);
  };
  return std::hypot(widened(half + apart), widened(std::max(0.0, half - apart)));
}

/// Whether that may be more than `least` times the filter's radius at either end of a segment between depths
/// `a` and `b`, whatever the disc, where the filter is that of the middle.
[[nodiscard]] inline bool filter_may_differ(double a, double b, double near, double least) {
  const double middle = std::max(0.5 * a + 0.5 * b, near);
  constexpr double root_two = 1.4142135623730951;
  const auto differs = [&](double z) {
    return !(root_two * std::abs(middle - std::max(z, near)) <= least * std::max(z, near));
  };
  return differs(a) || differs(b);
}

}  // namespace swept
