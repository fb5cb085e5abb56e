#include "splat/kernel/kernel_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <Eigen/Geometry>

#include "splat/motion/cut.h"
#include "splat/motion/instant.h"
#include "splat/motion/look.h"
#include "splat/motion/segments.h"

namespace swept {
namespace {

/// Spreads the low 21 bits of `v` to every third bit.
std::uint64_t every_third_bit(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

bool content_less(const MovingKernel& a, const MovingKernel& b) {
  const auto content = [](const MovingKernel& k) {
    return std::array<double, 30>{
        k.center.x(),   k.center.y(),     k.center.z(),     k.velocity.x(),    k.velocity.y(),
        k.velocity.z(), k.axis_u.x(),     k.axis_u.y(),     k.axis_u.z(),      k.axis_v.x(),
        k.axis_v.y(),   k.axis_v.z(),     k.facing.x(),     k.facing.y(),      k.facing.z(),
        k.t_begin,      k.t_end,          k.weight,         k.depth_tolerance, k.color.x(),
        k.color.y(),    k.color.z(),      k.color.w(),      k.outside.x(),     k.outside.y(),
        k.outside.z(),  k.color_rate.x(), k.color_rate.y(), k.color_rate.z(),  k.color_rate.w()};
  };
  return content(a) < content(b);
}

/// Sorts along a space-filling curve, for locality; equal keys by content. Identical kernels are
/// interchangeable, so the result does not depend on the order that came in.
void sort_by_content(std::vector<MovingKernel>& kernels) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  for (const MovingKernel& k : kernels) {
    low = low.cwiseMin(k.center);
    high = high.cwiseMax(k.center);
  }
  // Of 2²¹ along each axis. Halves, and a quotient of differences: neither overflows.
  const auto cell = [&](const MovingKernel& k, int axis) {
    const double range = 0.5 * high[axis] - 0.5 * low[axis];
    const double place = range > 0.0 ? (0.5 * k.center[axis] - 0.5 * low[axis]) / range : 0.0;
    return static_cast<std::uint64_t>(place * 0x1fffff);
  };

  struct Entry {
    std::uint64_t key;
    std::size_t index;
  };
  std::vector<Entry> order(kernels.size());
  for (std::size_t i = 0; i < kernels.size(); ++i) {
    const MovingKernel& k = kernels[i];
    order[i] = {
        every_third_bit(cell(k, 0)) | every_third_bit(cell(k, 1)) << 1 | every_third_bit(cell(k, 2)) << 2, i};
  }
  std::sort(order.begin(), order.end(), [&](const Entry& a, const Entry& b) {
    return a.key != b.key ? a.key < b.key : content_less(kernels[a.index], kernels[b.index]);
  });
  // Along the cycles of the permutation: kernels are most of the memory, and a second set of them would
  // double it.
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (order[i].index == i) continue;
    const MovingKernel first = kernels[i];
    std::size_t to = i;
    for (std::size_t from = order[to].index; from != i; from = order[to].index) {
      kernels[to] = kernels[from];
      order[to].index = to;
      to = from;
    }
    kernels[to] = first;
    order[to].index = to;
  }
}

/// Whether a path of segments is none.
bool still(const std::vector<PathSegment>& path) {
  const PathSegment& f = path.front();
  return std::all_of(path.begin(), path.end(), [&](const PathSegment& s) {
    return s.first == f.first && s.middle == f.first && s.last == f.first && s.axis_u == f.axis_u &&
           s.axis_v == f.axis_v;
  });
}

class Builder {
 public:
  Builder(const Scene& scene, const Exposure& exposure, const std::stop_token& stop, KernelSet& out)
      : scene_(scene), exposure_(exposure), stop_(stop), out_(out) {
    out.projection =
        projection_of(scene.film, scene.camera.at(exposure.of_all_rows(scene.film.height).middle()));
    out.near = scene.camera.near;
    // A guard band: beyond it a disc touches the frame with its rim only, if at all.
    constexpr double guard = 1.3;
    filter_.radius = scene.model.filter_radius_px / out.projection.focal_px;
    filter_.max_tangent_x = guard * largest_tangent(scene.film, out.projection, 0);
    filter_.max_tangent_y = guard * largest_tangent(scene.film, out.projection, 1);
    filter_.near = scene.camera.near;
    filter_.orthographic = out.projection.orthographic;
  }

  void add(const Object& object) {
    out_.surfels += object.discs();
    if (object.discs() == 0) return;
    const Exposure all = exposure_.of_all_rows(scene_.film.height);
    looks_change_ = looks_change(object.cloud, all.open, all.close);
    looks_.emplace(object.cloud, all.middle());
    if (cuts_by_point(scene_, object, exposure_))
      add_by_point(object, all);
    else
      add_alike(object);
  }

 private:
  /// Looked at for some of the points only.
  [[nodiscard]] bool stopped(std::size_t i) const { return i % 1024 == 0 && stop_.stop_requested(); }

  /// A mirrored object keeps its outside outside.
  void take_side(const Instant& instant) {
    side_ = instant.world_from_object.linear().determinant() < 0.0 ? -1.0 : 1.0;
  }

  /// What some of the points take, times all and a little more: a vector that grows holds everything twice.
  void reserve_for(PathCutter& cutter, std::size_t points, double tolerance) {
    const std::size_t stride = std::max<std::size_t>(1, points / 512);
    std::size_t segments = 0, looked_at = 0;
    for (std::size_t i = 0; i < points; i += stride, ++looked_at) segments += cutter.cut(i, tolerance).size();
    const double each =
        static_cast<double>(segments) / static_cast<double>(std::max<std::size_t>(1, looked_at));
    out_.kernels.reserve(out_.kernels.size() +
                         static_cast<std::size_t>(1.1 * each * static_cast<double>(points)));
  }

  void add_by_point(const Object& object, const Exposure& all) {
    take_side(instant_at(scene_, object, all, 0.5));
    PathCutter cutter(scene_, object, all);
    const double tolerance = path_tolerance_px(scene_);
    // Shutter time is that of the first row.
    const double begin = exposure_.curve ? 0.0 : (all.open - exposure_.open) / length();
    const double scale = exposure_.curve ? 1.0 : (all.close - all.open) / length();
    reserve_for(cutter, object.cloud.size(), tolerance);
    for (std::size_t i = 0; i < object.cloud.size(); ++i) {
      if (stopped(i)) return;
      const std::vector<PathSegment>& path = cutter.cut(i, tolerance);
      out_.most_segments = std::max(out_.most_segments, static_cast<int>(path.size()));
      for (PathSegment segment : path) {
        segment.begin = begin + scale * segment.begin;
        segment.end = begin + scale * segment.end;
        add_segment(object, i, segment, 1.0 / (segment.end - segment.begin));
      }
    }
  }

  void add_alike(const Object& object) {
    const int segments = linear_segments(scene_, object, exposure_);
    out_.most_segments = std::max(out_.most_segments, segments);
    std::vector<Instant> ends, middles;
    std::vector<SurfelsAt> at_ends, at_middles;
    std::vector<LooksAt> look_ends, look_middles;
    std::vector<double> times;
    for (int s = 0; s <= segments; ++s) times.push_back(segment_time(exposure_, s, segments));
    for (const double time : times) ends.push_back(instant_at(scene_, object, exposure_, time));
    for (int s = 0; s < segments; ++s)
      middles.push_back(instant_at(scene_, object, exposure_, segment_middle(exposure_, s, segments)));
    take_side(middles.front());
    for (const Instant& end : ends) at_ends.emplace_back(object.cloud, end.frame);
    for (const Instant& middle : middles) at_middles.emplace_back(object.cloud, middle.frame);
    if (looks_change_) {
      for (const Instant& end : ends) look_ends.emplace_back(object.cloud, end.frame);
      for (const Instant& middle : middles) look_middles.emplace_back(object.cloud, middle.frame);
    }
    const std::size_t count = object.cloud.size();
    out_.kernels.reserve(out_.kernels.size() + count * static_cast<std::size_t>(segments));
    std::vector<PathSegment> path(static_cast<std::size_t>(segments));
    for (std::size_t i = 0; i < count; ++i) {
      if (stopped(i)) return;
      Eigen::Vector3d first = ends[0].to_camera(at_ends[0][i].position);
      for (std::size_t s = 0; s < path.size(); ++s) {
        const SurfelInstant surfel = at_middles[s][i];
        const Eigen::Vector3d last = ends[s + 1].to_camera(at_ends[s + 1][i].position);
        path[s] = {times[s],
                   times[s + 1],
                   first,
                   middles[s].to_camera(surfel.position),
                   last,
                   middles[s].to_camera_direction(surfel.axis_u),
                   middles[s].to_camera_direction(surfel.axis_v)};
        if (looks_change_) {
          path[s].first_light = look_ends[s][i];
          path[s].middle_light = look_middles[s][i];
          path[s].last_light = look_ends[s + 1][i];
        }
        first = last;
      }
      if (!looks_change_ && still(path)) {
        PathSegment whole = path.front();
        whole.end = 1.0;
        add_segment(object, i, whole, 1.0);
        continue;
      }
      for (const PathSegment& segment : path)
        add_segment(object, i, segment,
                    exposure_.curve ? 1.0 / (segment.end - segment.begin) : double{1.0} * segments);
    }
  }

  [[nodiscard]] double length() const { return exposure_.close - exposure_.open; }

  /// Leaves of the kernel what its point is there for. False: nothing.
  bool clip_to_lifetime(const Lifetime& life, MovingKernel& kernel) const {
    const double before = kernel.t_mid();
    const Exposure all = exposure_.of_all_rows(scene_.film.height);
    if (all.instant()) return life.born <= all.open && all.open < life.gone;
    const auto time = [&](double frame) {
      return static_cast<float>(exposure_.curve ? exposure_.share_at(frame)
                                                : (frame - exposure_.open) / length());
    };
    if (life.born >= all.close || life.gone <= all.open) return false;
    if (life.born > all.open) kernel.t_begin = std::max(kernel.t_begin, time(life.born));
    if (life.gone < all.close) kernel.t_end = std::min(kernel.t_end, time(life.gone));
    if (!(kernel.t_begin < kernel.t_end)) return false;
    kernel.center += (kernel.t_mid() - before) * kernel.velocity;
    kernel.color += static_cast<float>(kernel.t_mid() - before) * kernel.color_rate;
    return true;
  }

  /// Even in time between the ends, and right in the mean, as the path is.
  void take_light(std::size_t i, const PathSegment& path, MovingKernel& kernel) const {
    if (!looks_change_) {
      kernel.color = (*looks_)[i];
      return;
    }
    const Eigen::Vector4f chord = path.first_light + 0.5f * (path.last_light - path.first_light);
    kernel.color = chord + (2.0f / 3.0f) * (path.middle_light - chord);
    kernel.color_rate = (path.last_light - path.first_light) / (kernel.t_end - kernel.t_begin);
  }

  void add_segment(const Object& object, std::size_t i, const PathSegment& path, double per_segment) {
    const Eigen::Vector3d &c0 = path.first, &c1 = path.last, &axis_u = path.axis_u, &axis_v = path.axis_v;
    MovingKernel kernel;
    // While no light comes in.
    if (!(static_cast<float>(path.begin) < static_cast<float>(path.end))) return;
    kernel.velocity = exposure_.curve ? Eigen::Vector3d((c1 - c0) / (path.end - path.begin))
                                      : Eigen::Vector3d((c1 - c0) * per_segment);
    // As far as the mean of the path lies from that of its chord, by Simpson's rule.
    const Eigen::Vector3d chord = c0 + 0.5 * (c1 - c0);
    kernel.center = chord + (2.0 / 3.0) * (path.middle - chord);
    kernel.t_begin = static_cast<float>(path.begin);
    kernel.t_end = static_cast<float>(path.end);

    const FilteredDisc disc = filter_disc(kernel.center, axis_u, axis_v, filter_);
    if (!(static_cast<float>(disc.weight) > 0.0f)) {
      ++out_.culled_degenerate;
      return;
    }
    const double reach = std::hypot(disc.axis_u.z(), disc.axis_v.z());
    if (std::max(c0.z(), c1.z()) + reach < out_.near) {
      ++out_.culled_near;
      return;
    }
    kernel.axis_u = disc.axis_u.cast<float>();
    kernel.axis_v = disc.axis_v.cast<float>();
    kernel.weight = static_cast<float>(disc.weight);
    kernel.depth_tolerance = static_cast<float>(scene_.model.depth_tolerance * disc.size);
    kernel.facing.setZero();
    // Coordinates near the end of a double's range, or sizes near that of a float's.
    constexpr float largest = 1e30f;
    if (!kernel.center.allFinite() || !kernel.velocity.allFinite() || !kernel.axis_u.allFinite() ||
        !kernel.axis_v.allFinite() || !(kernel.depth_tolerance <= largest)) {
      ++out_.culled_degenerate;
      return;
    }
    // Normalised before it becomes a float: the product of two tiny axes would underflow.
    const bool oriented = object.cloud.is_oriented(i);
    if (!object.two_sided || oriented) {
      const Eigen::Vector3f outside = (side_ * axis_u.cross(axis_v).stableNormalized()).cast<float>();
      if (!object.two_sided) kernel.facing = outside;
      if (oriented) kernel.outside = outside;
    }
    take_light(i, path, kernel);
    if (!object.cloud.lifetime.empty() && !clip_to_lifetime(object.cloud.lifetime[i], kernel)) return;
    if (kernel.still()) ++out_.still_kernels;
    const Eigen::Vector3d normal = axis_u.cross(axis_v);
    const bool edge_on = filter_.orthographic ? std::abs(normal.z()) < 1e-3 * normal.norm()
                                              : std::abs(normal.dot(kernel.center)) <
                                                    1e-3 * normal.norm() * kernel.center.norm();
    if (edge_on) ++out_.edge_on_kernels;
    if (std::min(c0.z(), c1.z()) - reach < out_.near) ++out_.near_kernels;
    out_.kernels.push_back(kernel);
  }

  const Scene& scene_;
  Exposure exposure_;
  const std::stop_token& stop_;
  KernelSet& out_;
  PixelFilter filter_;
  double side_ = 1.0;             ///< −1: the object is mirrored
  bool looks_change_ = false;     ///< those of the object being added
  std::optional<LooksAt> looks_;  ///< of it, in the middle of the exposure
};

}  // namespace

KernelSet build_kernels(const Scene& scene, const Exposure& exposure, const std::stop_token& stop) {
  KernelSet set;
  Builder builder(scene, exposure, stop, set);
  for (const Object& object : scene.objects) {
    const std::size_t before = set.still_kernels;
    builder.add(object);
    if (stands_still(scene, object, exposure)) set.standing_kernels += set.still_kernels - before;
  }
  if (!stop.stop_requested()) sort_by_content(set.kernels);
  return set;
}

}  // namespace swept
