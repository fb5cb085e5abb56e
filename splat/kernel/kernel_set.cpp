#include "splat/kernel/kernel_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Geometry>

#include "splat/motion/instant.h"
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
    return std::array<double, 27>{
        k.center.x(),      k.center.y(),  k.center.z(), k.velocity.x(), k.velocity.y(), k.velocity.z(),
        k.axis_u.x(),      k.axis_u.y(),  k.axis_u.z(), k.axis_v.x(),   k.axis_v.y(),   k.axis_v.z(),
        k.facing.x(),      k.facing.y(),  k.facing.z(), k.t_begin,      k.t_end,        k.weight,
        k.depth_tolerance, k.color.x(),   k.color.y(),  k.color.z(),    k.color.w(),    k.outside.x(),
        k.outside.y(),     k.outside.z(), 0.0};
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
  std::vector<MovingKernel> sorted;
  sorted.reserve(kernels.size());
  for (const Entry& entry : order) sorted.push_back(kernels[entry.index]);
  kernels = std::move(sorted);
}

/// All the path of one surfel that a segment needs: centres at the ends and in the middle, axes in the
/// middle.
struct Path {
  std::vector<Eigen::Vector3d> centers;                           ///< segments + 1
  std::vector<Eigen::Vector3d> middles;                           ///< segments
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> axes;  ///< segments
  std::vector<double> times;                                      ///< segments + 1, from 0 to 1

  [[nodiscard]] bool still() const {
    const auto at_start = [&](const Eigen::Vector3d& c) { return c == centers.front(); };
    return std::all_of(centers.begin(), centers.end(), at_start) &&
           std::all_of(middles.begin(), middles.end(), at_start) &&
           std::all_of(axes.begin(), axes.end(), [&](const auto& a) { return a == axes.front(); });
  }
};

class Builder {
 public:
  Builder(const Scene& scene, const Exposure& exposure, KernelSet& out)
      : scene_(scene), exposure_(exposure), out_(out) {
    out.projection = projection_of(scene.film, scene.camera.at(exposure.middle()));
    out.near = scene.camera.near;
    // A guard band: beyond it a disc touches the frame with its rim only, if at all.
    constexpr double guard = 1.3;
    filter_.radius = scene.model.filter_radius_px / out.projection.focal_px;
    filter_.max_tangent_x = guard * largest_tangent(scene.film, out.projection, 0);
    filter_.max_tangent_y = guard * largest_tangent(scene.film, out.projection, 1);
    filter_.near = scene.camera.near;
  }

  void add(const Object& object) {
    const int segments = linear_segments(scene_, object, exposure_);
    out_.most_segments = std::max(out_.most_segments, segments);
    std::vector<Instant> ends, middles;
    Path path;
    for (int s = 0; s <= segments; ++s) path.times.push_back(segment_time(exposure_, s, segments));
    for (const double time : path.times) ends.push_back(instant_at(scene_, object, exposure_, time));
    for (int s = 0; s < segments; ++s)
      middles.push_back(instant_at(scene_, object, exposure_, segment_middle(exposure_, s, segments)));
    const std::size_t count = object.discs();
    out_.surfels += count;
    out_.kernels.reserve(out_.kernels.size() + count * static_cast<std::size_t>(segments));
    for (std::size_t i = 0; i < count; ++i) {
      path.centers.clear();
      path.middles.clear();
      path.axes.clear();
      for (const Instant& end : ends)
        path.centers.push_back(end.to_camera(surfel_at(object.cloud, i, end.frame).position));
      for (const Instant& middle : middles) {
        const SurfelInstant surfel = surfel_at(object.cloud, i, middle.frame);
        path.middles.push_back(middle.to_camera(surfel.position));
        path.axes.emplace_back(middle.to_camera_direction(surfel.axis_u),
                               middle.to_camera_direction(surfel.axis_v));
      }
      const bool still = path.still();
      const int pieces = still ? 1 : segments;
      // A mirrored object keeps its outside outside.
      const double side = middles.front().world_from_object.linear().determinant() < 0.0 ? -1.0 : 1.0;
      for (int s = 0; s < pieces; ++s) add_segment(object, i, path, s, pieces, side);
    }
  }

 private:
  void add_segment(const Object& object, std::size_t i, const Path& path, int s, int pieces, double side) {
    const Eigen::Vector3d& c0 = path.centers[s];
    const Eigen::Vector3d& c1 = path.centers[s + 1];
    const auto& [axis_u, axis_v] = path.axes[s];
    MovingKernel kernel;
    const bool whole = pieces == 1;
    const double begin = whole ? 0.0 : path.times[s], end = whole ? 1.0 : path.times[s + 1];
    // While no light comes in.
    if (!(static_cast<float>(begin) < static_cast<float>(end))) return;
    kernel.velocity = exposure_.curve ? Eigen::Vector3d((c1 - c0) / (end - begin)) : (c1 - c0) * pieces;
    // As far as the mean of the path lies from that of its chord, by Simpson's rule.
    const Eigen::Vector3d chord = c0 + 0.5 * (c1 - c0);
    kernel.center = chord + (2.0 / 3.0) * (path.middles[s] - chord);
    kernel.t_begin = static_cast<float>(begin);
    kernel.t_end = static_cast<float>(end);

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
      const Eigen::Vector3f outside = (side * axis_u.cross(axis_v).stableNormalized()).cast<float>();
      if (!object.two_sided) kernel.facing = outside;
      if (oriented) kernel.outside = outside;
    }
    const float opacity = object.cloud.opacity.empty() ? 1.0f : object.cloud.opacity[i];
    kernel.color.head<3>() =
        opacity * (object.cloud.color.empty() ? Eigen::Vector3f::Ones() : object.cloud.color[i]);
    kernel.color.w() = opacity;
    if (kernel.still()) ++out_.still_kernels;
    const Eigen::Vector3d normal = axis_u.cross(axis_v);
    if (std::abs(normal.dot(kernel.center)) < 1e-3 * normal.norm() * kernel.center.norm())
      ++out_.edge_on_kernels;
    if (std::min(c0.z(), c1.z()) - reach < out_.near) ++out_.near_kernels;
    out_.kernels.push_back(kernel);
  }

  const Scene& scene_;
  Exposure exposure_;
  KernelSet& out_;
  PixelFilter filter_;
};

}  // namespace

KernelSet build_kernels(const Scene& scene, const Exposure& exposure) {
  KernelSet set;
  Builder builder(scene, exposure, set);
  for (const Object& object : scene.objects) {
    const std::size_t before = set.still_kernels;
    builder.add(object);
    if (stands_still(scene, object, exposure)) set.standing_kernels += set.still_kernels - before;
  }
  sort_by_content(set.kernels);
  return set;
}

}  // namespace swept
