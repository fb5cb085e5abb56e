// Which axes a segment has, and whether they follow the disc.
#include "splat/motion/cut.h"

#include <cmath>

#include "splat/motion/rims.h"
#include "splat/motion/turns.h"

namespace swept {
namespace {

/// Of what rims and filters may be off by: what changes less keeps the axes of its middle, and of discs that
/// come to show another side no more is left so.
constexpr double least_turn = 0.25;
/// What rims may be off by where axes are parabolas, of the tolerance: less, for all discs that come nearer
/// err to one side at one time.
constexpr double turn_part = 0.05;
/// Where a ray through the centre may see the disc there, as a part of the tolerance: this is how far a disc
/// that passes every other test may still be from its path, for all of its segment.
constexpr double ray_part = 0.1;
/// Of a disc's weight in the middle: by how much it may change while a ray sees it, and be off a parabola.
constexpr double most_weight_change = 0.5, most_weight_off = 0.02;

KernelPlane<double> plane_of(const FilteredDisc& disc, const Eigen::Vector3d& center, bool orthographic) {
  MovingKernel kernel;
  kernel.center = center;
  kernel.velocity.setZero();
  kernel.axis_u = disc.axis_u.cast<float>();
  kernel.axis_v = disc.axis_v.cast<float>();
  kernel.facing.setZero();
  return KernelPlane<double>(kernel, orthographic);
}

}  // namespace

/// The pixel filter is a length in the middle, where it has the size of a pixel.
bool PathCutter::same_filter(const Seen& end, const Seen& middle, double part) const {
  const double scale = visible_scale(end.center), near = scene_.camera.near;
  if (projection_.orthographic || !(scale > 0.0)) return true;
  const double tolerance_px = part * filters_per_path * tolerance_px_, z = end.center.z();
  const double filter_px = scene_.model.filter_radius_px;
  if (!filter_may_differ(z, 2.0 * middle.center.z() - z, near, tolerance_px / filter_px)) return true;
  const double true_radius = filter_px / projection_.focal_px * z;
  const double radius = true_radius * (std::max(middle.center.z(), near) / z);
  return !(filters_apart_px({end.axis_u, end.axis_v}, end.center.x() / z, end.center.y() / z, scale, radius,
                            true_radius) > tolerance_px);
}

/// What the filter makes of a disc depends on where it is seen from: from beside, one is narrower than the
/// filter and weighs less. The middle's is seen where the disc is.
bool PathCutter::same_from_the_side(const Seen& end, const Seen& middle, double part) const {
  const double scale = visible_scale(end.center), filter_px = scene_.model.filter_radius_px;
  if (shape_ == SegmentShape::chords || !(scale > 0.0) || filter_px == 0.0) return true;
  const double tolerance_px = part * filters_per_path * tolerance_px_;
  // Widths change by no more than this, and weights by no more than this over the filter's.
  const Eigen::Vector2d aside = ray_of(end.center) - ray_of(middle.center);
  const double most_px = scale * aside.norm() * std::hypot(end.axis_u.z(), end.axis_v.z());
  if (!(most_px > tolerance_px * std::min(1.0, filter_px))) return true;
  const FilteredDisc there = filtered(middle, nullptr);
  const FilmDisc truth(filtered(end, &there), end.center, projection_);
  const FilmDisc frozen(there, end.center, projection_);
  // Weights of what is narrow are of little.
  const double width_px = std::abs(truth.film.determinant()) / truth.film.norm();
  return !((truth.film - frozen.film).norm() > tolerance_px ||
           std::min(1.0, width_px) * std::abs(truth.weight - frozen.weight) > tolerance_px);
}

bool PathCutter::near_middle(const Seen& end, const Seen& middle, double part) const {
  if (!same_filter(end, middle, part) || !same_from_the_side(end, middle, part)) return false;
  const double scale = visible_scale(middle.center);
  if (!(scale > 0.0)) return true;
  const Eigen::Vector2d ray = ray_of(middle.center);
  return !(rims_apart_px({end.axis_u, end.axis_v}, {middle.axis_u, middle.axis_v}, ray.x(), ray.y(), scale) >
           part * rims_per_path * tolerance_px_);
}

/// As build_kernels() has it; turned within itself, if to be as near as it can to another.
FilteredDisc PathCutter::filtered(const Seen& seen, const FilteredDisc* towards) const {
  FilteredDisc disc = filter_disc(seen.center, seen.axis_u, seen.axis_v, filter_);
  if (towards != nullptr) turn_towards(towards->axis_u, towards->axis_v, disc.axis_u, disc.axis_v);
  return disc;
}

bool PathCutter::shows_one_side(const Seen& first, const Seen& middle, const Seen& last) const {
  const auto side = [&](const Seen& seen) {
    if (!(seen.center.z() > scene_.camera.near)) return 0;
    const Eigen::Vector3d normal = seen.axis_u.cross(seen.axis_v);
    const double faces = projection_.orthographic ? normal.z() : normal.dot(seen.center);
    return faces > 0.0 ? 1 : faces < 0.0 ? -1 : 0;
  };
  return side(middle) != 0 && side(first) == side(middle) && side(last) == side(middle);
}

/// Whether those of the middle are near enough all along.
bool PathCutter::keeps_axes(const Seen& first, const Seen& middle, const Seen& last) const {
  const double part = shape_ == SegmentShape::parabolas ? least_turn : 1.0;
  return near_middle(first, middle, part) && near_middle(last, middle, part);
}

/// Whether a segment's axes may change: not where another side of the disc comes to be seen.
bool PathCutter::may_turn(const Seen& first, const Seen& middle, const Seen& last) const {
  return shape_ == SegmentShape::parabolas && shows_one_side(first, middle, last);
}

/// Whether they do: not where they hardly would.
bool PathCutter::turns(const Seen& first, const Seen& middle, const Seen& last) const {
  return may_turn(first, middle, last) && !keeps_axes(first, middle, last);
}

PathCutter::Axes PathCutter::axes_of(const Seen& first, const Seen& middle, const Seen& last) const {
  Axes axes;
  axes.follow = keeps_axes(first, middle, last);
  if (axes.follow || !may_turn(first, middle, last)) return axes;
  const FilteredDisc& there = axes.middle = filtered(middle, nullptr);
  const FilteredDisc from = filtered(first, &there), to = filtered(last, &there);
  axes.turn.emplace(FilmDisc(from, first.center, projection_), FilmDisc(there, middle.center, projection_),
                    FilmDisc(to, last.center, projection_));
  const bool parallel = projection_.orthographic;
  axes.planes = {plane_of(from, first.center, parallel), plane_of(there, middle.center, parallel),
                 plane_of(to, last.center, parallel)};
  const double share = seen_share(first, middle, last);
  axes.follow = axes.turn->bend_px() * share * share <= turn_part * tolerance_px_ &&
                axes.turn->weight_change() * share <= most_weight_change;
  return axes;
}

/// Whether they follow the disc at a share of the time, too.
bool PathCutter::near_axes(const Axes& axes, const Seen& middle, const Seen& truth, double share) const {
  if (!axes.turn) return near_middle(truth, middle);
  const FilmDisc disc(filtered(truth, &axes.middle), truth.center, projection_);
  if (!(axes.turn->off_px(disc, share) <= turn_part * tolerance_px_ &&
        axes.turn->weight_off(disc, share) <= most_weight_off))
    return false;
  // A ray through the centre there is far from the disc at the ends, where a disc that turns looks otherwise.
  const Eigen::Vector3d off = axes.along(
      projection_.orthographic ? Eigen::Vector2d(truth.center.head<2>()) : ray_of(truth.center), share);
  return (disc.film * off.head<2>()).norm() <= ray_part * tolerance_px_ &&
         visible_scale(truth.center) * std::abs(off.z() - truth.center.z()) <= ray_part * tolerance_px_;
}

}  // namespace swept
