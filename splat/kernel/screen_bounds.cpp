#include "splat/kernel/screen_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "splat/kernel/turning_kernel.h"

namespace swept {
namespace {

/// Rounding of the projection and of the fragment's own coordinates, with orders of magnitude to spare: both
/// are relative 1e-7 (float axes) of a footprint that matters only where it is on the film.
constexpr double padding_px = 1.0 / 256.0;
constexpr double padding_relative = 1e-6;

PixelBox empty_box() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {infinity, -infinity, infinity, -infinity};
}

/// What is not a number, or too large to calculate with, becomes the whole plane.
PixelBox padded(const PixelBox& box) {
  constexpr double limit = 1e300;
  const double x = padding_px + padding_relative * (box.x_max - box.x_min);
  const double y = padding_px + padding_relative * (box.y_max - box.y_min);
  const auto low = [&](double value) { return value > -limit ? std::min(value, limit) : -limit; };
  const auto high = [&](double value) { return value < limit ? std::max(value, -limit) : limit; };
  return {low(box.x_min - x), high(box.x_max + x), low(box.y_min - y), high(box.y_max + y)};
}

struct Range {
  double low, high;
};

/// Extent of x/z over the disc, for a disc wholly at z > 0. The tangents to the disc through the eye satisfy
/// c_x − x c_z = ±√((a_x − x a_z)² + (b_x − x b_z)²). Sheared so that c_x = 0, the discriminant is a sum of
/// positive terms. In units of c_z, for squares to stay in range.
Range tangent_extent(double cx, double cz, double ax, double az, double bx, double bz) {
  const double center = cx / cz;
  az /= cz;
  bz /= cz;
  const double sx = ax / cz - center * az, sy = bx / cz - center * bz;
  const double a = 1.0 - az * az - bz * bz;
  const double half_b = -(sx * az + sy * bz);
  const double root = std::sqrt(half_b * half_b + a * (sx * sx + sy * sy));
  return {center + (half_b - root) / a, center + (half_b + root) / a};
}

PixelBox project_disc(const Eigen::Vector3d& c, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                      const Projection& p) {
  const Range x = tangent_extent(c.x(), c.z(), a.x(), a.z(), b.x(), b.z());
  const Range y = tangent_extent(c.y(), c.z(), a.y(), a.z(), b.y(), b.z());
  return {p.center_x + p.focal_px * x.low, p.center_x + p.focal_px * x.high, p.center_y + p.focal_px * y.low,
          p.center_y + p.focal_px * y.high};
}

/// Of an orthographic camera.
PixelBox parallel_box(const Eigen::Vector3d& c, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                      const Projection& p) {
  const double x = std::hypot(a.x(), b.x()), y = std::hypot(a.y(), b.y());
  return {p.center_x + p.focal_px * (c.x() - x), p.center_x + p.focal_px * (c.x() + x),
          p.center_y + p.focal_px * (c.y() - y), p.center_y + p.focal_px * (c.y() + y)};
}

/// Corners of the two parallelograms around the discs: their hull contains the tube. Its part beyond the near
/// plane is the hull of the corners there and of the edges' crossings.
bool project_clipped(std::span<const Eigen::Vector3d> corners, const Projection& p, double near,
                     PixelBox& box) {
  box = empty_box();
  const auto include = [&](const Eigen::Vector3d& point, double z) {
    const double x = p.center_x + p.focal_px * point.x() / z, y = p.center_y + p.focal_px * point.y() / z;
    box = {std::min(box.x_min, x), std::max(box.x_max, x), std::min(box.y_min, y), std::max(box.y_max, y)};
  };
  bool any = false;
  for (const Eigen::Vector3d& corner : corners) {
    if (corner.z() < near) continue;
    any = true;
    include(corner, corner.z());
    for (const Eigen::Vector3d& other : corners) {
      if (other.z() >= near) continue;
      const double s = (near - corner.z()) / (other.z() - corner.z());
      include(corner + s * (other - corner), near);
    }
  }
  return any;
}

}  // namespace

PixelBox Octagon::box() const {
  return {std::min(begin.x_min, end.x_min), std::max(begin.x_max, end.x_max),
          std::min(begin.y_min, end.y_min), std::max(begin.y_max, end.y_max)};
}

namespace {

/// Narrows [s.low, s.high] to where a + s·(b − a) ≤ limit.
void where_at_most(double a, double b, double limit, Range& s) {
  if (a == b) {
    if (a > limit) s.high = -1.0;
    return;
  }
  const double crossing = (limit - a) / (b - a);
  if (b > a)
    s.high = std::min(s.high, crossing);
  else
    s.low = std::max(s.low, crossing);
}

}  // namespace

bool Octagon::overlaps(const PixelBox& window) const {
  Range s{0.0, 1.0};
  where_at_most(begin.x_min, end.x_min, window.x_max, s);
  where_at_most(-begin.x_max, -end.x_max, -window.x_min, s);
  where_at_most(begin.y_min, end.y_min, window.y_max, s);
  where_at_most(-begin.y_max, -end.y_max, -window.y_min, s);
  return s.low <= s.high;
}

bool Octagon::span(double y_min, double y_max, double& x_min, double& x_max) const {
  Range s{0.0, 1.0};
  where_at_most(begin.y_min, end.y_min, y_max, s);
  where_at_most(-begin.y_max, -end.y_max, -y_min, s);
  if (!(s.low <= s.high)) return false;
  const auto blend = [](double a, double b, double t) { return a + t * (b - a); };
  // Rounding of the blend itself, relative to the longest streak.
  const double slack =
      padding_px + 1e-12 * std::max(std::abs(end.x_min - begin.x_min), std::abs(end.x_max - begin.x_max));
  x_min = std::min(blend(begin.x_min, end.x_min, s.low), blend(begin.x_min, end.x_min, s.high)) - slack;
  x_max = std::max(blend(begin.x_max, end.x_max, s.low), blend(begin.x_max, end.x_max, s.high)) + slack;
  return true;
}

namespace {

PixelBox united(const PixelBox& a, const PixelBox& b) {
  return {std::min(a.x_min, b.x_min), std::max(a.x_max, b.x_max), std::min(a.y_min, b.y_min),
          std::max(a.y_max, b.y_max)};
}

/// A disc somewhere.
struct PlacedDisc {
  Eigen::Vector3d center, u, v;
};

/// Of what lies in the hull of the first and of the last four.
bool hull_bounds(const std::array<PlacedDisc, 8>& discs, const Projection& projection, double near,
                 double margin_px, Octagon& octagon) {
  double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
  for (const PlacedDisc& disc : discs) {
    const double reach = std::hypot(disc.u.z(), disc.v.z());
    nearest = std::min(nearest, disc.center.z() - reach);
    farthest = std::max(farthest, disc.center.z() + reach);
  }
  if (farthest < near) return false;
  const auto wider = [&](PixelBox box) {
    return padded(
        {box.x_min - margin_px, box.x_max + margin_px, box.y_min - margin_px, box.y_max + margin_px});
  };
  const auto boxes = [&](const auto& box_of) {
    const auto around = [&](std::size_t first) {
      PixelBox box = empty_box();
      for (std::size_t k = first; k < first + 4; ++k)
        box = united(box, box_of(discs[k].center, discs[k].u, discs[k].v, projection));
      return wider(box);
    };
    octagon = {around(0), around(4)};
    return true;
  };
  if (projection.orthographic) return boxes(parallel_box);
  if (nearest > near) return boxes(project_disc);
  std::array<Eigen::Vector3d, 32> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const PlacedDisc& disc = discs[k / 4];
    corners[k] = disc.center + (k % 2 == 0 ? disc.u : Eigen::Vector3d(-disc.u)) +
                 (k / 2 % 2 == 0 ? disc.v : Eigen::Vector3d(-disc.v));
  }
  PixelBox box;
  if (!project_clipped(corners, projection, near, box)) return false;
  octagon = {wider(box), wider(box)};
  return true;
}

/// A parabola is within the hull of its straight line's ends, each moved as far as it leaves the line to
/// either side.
std::array<Eigen::Vector3d, 4> parabola_hull(const MovingKernel& kernel) {
  const double half = kernel.half_time();
  const Eigen::Vector3d way = half * kernel.velocity, bend = half * half / 3.0 * kernel.bend;
  return {kernel.center - way - bend, kernel.center - way + 2.0 * bend, kernel.center + way - bend,
          kernel.center + way + 2.0 * bend};
}

bool bent_bounds(const MovingKernel& kernel, const Projection& projection, double near, Octagon& octagon) {
  const auto ends = parabola_hull(kernel);
  const Eigen::Vector3d a = kernel.axis_u.cast<double>(), b = kernel.axis_v.cast<double>();
  return hull_bounds({{{ends[0], a, b},
                       {ends[1], a, b},
                       {ends[1], a, b},
                       {ends[1], a, b},
                       {ends[2], a, b},
                       {ends[3], a, b},
                       {ends[3], a, b},
                       {ends[3], a, b}}},
                     projection, near, 0.0, octagon);
}

}  // namespace

bool screen_bounds(const MovingKernel& kernel, const Projection& projection, double near, Octagon& octagon) {
  if (kernel.bent()) return bent_bounds(kernel, projection, near, octagon);
  const double half = 0.5 * (static_cast<double>(kernel.t_end) - static_cast<double>(kernel.t_begin));
  const Eigen::Vector3d c0 = kernel.center - half * kernel.velocity,
                        c1 = kernel.center + half * kernel.velocity;
  const Eigen::Vector3d a = kernel.axis_u.cast<double>(), b = kernel.axis_v.cast<double>();
  const double reach = std::hypot(a.z(), b.z());
  if (std::max(c0.z(), c1.z()) + reach < near) return false;
  if (projection.orthographic) {
    octagon = {padded(parallel_box(c0, a, b, projection)), padded(parallel_box(c1, a, b, projection))};
    return true;
  }
  if (std::min(c0.z(), c1.z()) - reach > near) {
    octagon = {padded(project_disc(c0, a, b, projection)), padded(project_disc(c1, a, b, projection))};
    return true;
  }
  PixelBox box;
  const std::array<Eigen::Vector3d, 8> corners{c0 + a + b, c0 + a - b, c0 - a + b, c0 - a - b,
                                               c1 + a + b, c1 + a - b, c1 - a + b, c1 - a - b};
  if (!project_clipped(corners, projection, near, box)) return false;
  box = padded(box);
  octagon = {box, box};
  return true;
}

/// Axes on a parabola are between those of the ends, and no more beside than in the middle: so is every point
/// of the disc.
bool turning_bounds(const MovingKernel& kernel, const DiscTurn& turn, const Projection& projection,
                    double near, Octagon& octagon) {
  // By what a line fitted to the coordinates that a ray sees may leave the disc itself.
  constexpr double margin_px = 1.0 / 8.0;
  const double half = kernel.half_time();
  const auto ends = parabola_hull(kernel);
  const DiscTurn::Axes first = turn.at(kernel, kernel.t_begin), last = turn.at(kernel, kernel.t_end);
  const Eigen::Vector3d u = -half * half * turn.u_bend.cast<double>(),
                        v = -half * half * turn.v_bend.cast<double>();
  return hull_bounds({{{ends[0], first.u, first.v},
                       {ends[1], first.u, first.v},
                       {ends[0], first.u + u, first.v + v},
                       {ends[1], first.u + u, first.v + v},
                       {ends[2], last.u, last.v},
                       {ends[3], last.u, last.v},
                       {ends[2], last.u + u, last.v + v},
                       {ends[3], last.u + u, last.v + v}}},
                     projection, near, margin_px, octagon);
}

}  // namespace swept
