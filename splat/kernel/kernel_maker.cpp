#include "splat/kernel/kernel_maker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "splat/kernel/scene_filter.h"
#include "splat/motion/cut.h"
#include "splat/motion/instant.h"
#include "splat/motion/look.h"
#include "splat/motion/segments.h"

namespace swept {
namespace {

constexpr std::uint32_t whole_path = ~0u;

/// Whether a path of segments is none.
bool still(const std::vector<PathSegment>& path) {
  const PathSegment& f = path.front();
  return std::all_of(path.begin(), path.end(), [&](const PathSegment& s) {
    return s.first == f.first && s.middle == f.first && s.last == f.first && s.axis_u == f.axis_u &&
           s.axis_v == f.axis_v;
  });
}

/// The paths of an object's points, all cut alike.
class AlikePaths {
 public:
  AlikePaths(const Scene& scene, const Object& object, const Exposure& exposure, bool looks_change,
             bool still)
      : looks_change_(looks_change) {
    const int segments = still ? 1 : linear_segments(scene, object, exposure);
    for (int s = 0; s <= segments; ++s) {
      times_.push_back(segment_time(exposure, s, segments));
      ends_.push_back(place(scene, object, exposure, times_.back()));
      if (s < segments)
        middles_.push_back(place(scene, object, exposure, segment_middle(exposure, s, segments)));
    }
  }

  [[nodiscard]] std::size_t segments() const { return middles_.size(); }
  [[nodiscard]] const Instant& first_middle() const { return middles_.front().instant; }
  /// `whole_path`: of one whose segments are none.
  [[nodiscard]] PathSegment segment(std::size_t i, std::uint32_t piece) const {
    const std::size_t s = piece == whole_path ? 0 : piece;
    const Place &first = ends_[s], &middle = middles_[s], &last = ends_[s + 1];
    const SurfelInstant surfel = middle.surfels[i];
    PathSegment segment{times_[s],
                        piece == whole_path ? 1.0 : times_[s + 1],
                        first.instant.to_camera(first.surfels.position(i)),
                        middle.instant.to_camera(surfel.position),
                        last.instant.to_camera(last.surfels.position(i)),
                        middle.instant.to_camera_direction(surfel.axis_u),
                        middle.instant.to_camera_direction(surfel.axis_v)};
    segment.piece = piece;
    segment.at_first = &first.instant;
    segment.at_middle = &middle.instant;
    segment.at_last = &last.instant;
    segment.first_u = segment.last_u = segment.axis_u;
    segment.first_v = segment.last_v = segment.axis_v;
    // Discs do not turn or grow where all are cut alike, unless somebody asked for it; films may.
    if (first.instant.zooms() || last.instant.zooms()) {
      const SurfelInstant from = first.surfels[i], to = last.surfels[i];
      segment.first_u = first.instant.to_camera_direction(from.axis_u);
      segment.first_v = first.instant.to_camera_direction(from.axis_v);
      segment.last_u = last.instant.to_camera_direction(to.axis_u);
      segment.last_v = last.instant.to_camera_direction(to.axis_v);
    }
    if (looks_change_) {
      segment.first_light = first.looks[i];
      segment.middle_light = middle.looks[i];
      segment.last_light = last.looks[i];
    }
    return segment;
  }

 private:
  struct Place {
    Instant instant;
    SurfelsAt surfels;
    LooksAt looks;
  };
  static Place place(const Scene& scene, const Object& object, const Exposure& exposure, double time) {
    const Instant instant = instant_at(scene, object, exposure, time);
    return {instant, SurfelsAt(object.cloud, instant.frame), LooksAt(object.cloud, instant.frame)};
  }

  bool looks_change_;
  std::vector<double> times_;
  std::vector<Place> ends_, middles_;
};

}  // namespace

/// Those of one object's points.
class ObjectKernels {
 public:
  ObjectKernels(const Scene& scene, const Object& object, const Exposure& exposure,
                const Projection& projection, SegmentShape shape)
      : scene_(scene),
        object_(object),
        exposure_(exposure),
        all_(exposure.of_all_rows(scene.film.height)),
        filter_(filter_of(scene, projection)),
        looks_change_(looks_change(object.cloud, all_.open, all_.close)),
        looks_(object.cloud, all_.middle()),
        still_(stands_still(scene, object, exposure)),
        tolerance_(path_tolerance_px(scene)) {
    if (!still_ && cuts_by_point(scene, object, exposure)) {
      cutter_.emplace(scene, object, all_, shape);
      take_side(instant_at(scene, object, all_, 0.5));
    } else {
      alike_.emplace(scene, object, exposure, looks_change_, still_);
      take_side(alike_->first_middle());
    }
    // Shutter time is that of the first row; what stands still is there for the others, too.
    if (exposure.row_delay != 0.0 && length() > 0.0) {
      begin_ = (all_.open - exposure.open) / length();
      scale_ = (all_.close - all_.open) / length();
    }
  }

  [[nodiscard]] std::size_t expected() {
    const std::size_t points = object_.cloud.size();
    if (alike_) return points * alike_->segments();
    const std::size_t stride = std::max<std::size_t>(1, points / 512);
    std::size_t segments = 0, looked_at = 0;
    for (std::size_t i = 0; i < points; i += stride, ++looked_at)
      segments += cutter_->cut(i, tolerance_).size();
    const double each =
        static_cast<double>(segments) / static_cast<double>(std::max<std::size_t>(1, looked_at));
    return static_cast<std::size_t>(1.1 * each * static_cast<double>(points));
  }

  void make_all(std::size_t first_point, const KernelMaker::Visit& visit, const std::stop_token& stop,
                KernelCounts& counts) {
    const std::size_t still_before = counts.still_kernels;
    std::vector<PathSegment> alike(alike_ ? alike_->segments() : 0);
    if (alike_) counts.most_segments = std::max(counts.most_segments, static_cast<int>(alike.size()));
    for (std::size_t i = 0; i < object_.cloud.size(); ++i) {
      // Looked at for some of the points only.
      if (i % 1024 == 0 && stop.stop_requested()) return;
      const auto make = [&](const PathSegment& segment) {
        MovingKernel kernel;
        std::optional<DiscTurn> turn;
        if (fill(i, segment, kernel, turn, counts))
          visit({static_cast<std::uint32_t>(first_point + i), segment.piece}, kernel,
                turn ? &*turn : nullptr);
      };
      if (cutter_) {
        const std::vector<PathSegment>& path = cutter_->cut(i, tolerance_);
        counts.most_segments = std::max(counts.most_segments, static_cast<int>(path.size()));
        for (const PathSegment& segment : path) make(segment);
        continue;
      }
      for (std::size_t s = 0; s < alike.size(); ++s)
        alike[s] = alike_->segment(i, static_cast<std::uint32_t>(s));
      if (!looks_change_ && still(alike))
        make(alike_->segment(i, whole_path));
      else
        for (const PathSegment& segment : alike) make(segment);
    }
    if (still_) counts.standing_kernels += counts.still_kernels - still_before;
  }

  [[nodiscard]] MovingKernel make(std::size_t i, std::uint32_t piece, std::optional<DiscTurn>& turn) const {
    MovingKernel kernel;
    KernelCounts not_again;
    fill(i, cutter_ ? cutter_->segment(i, piece) : alike_->segment(i, piece), kernel, turn, not_again);
    return kernel;
  }

 private:
  /// A mirrored object keeps its outside outside.
  void take_side(const Instant& instant) {
    side_ = instant.world_from_object.linear().determinant() < 0.0 ? -1.0 : 1.0;
  }

  bool fill(std::size_t i, PathSegment segment, MovingKernel& kernel, std::optional<DiscTurn>& turn,
            KernelCounts& counts) const {
    segment.begin = begin_ + scale_ * segment.begin;
    segment.end = begin_ + scale_ * segment.end;
    const double length_of_time = segment.end - segment.begin;
    const bool evenly = alike_ && !exposure_.curve && segment.piece != whole_path;
    return fill(i, segment, evenly ? static_cast<double>(alike_->segments()) : 1.0 / length_of_time, kernel,
                turn, counts);
  }

  [[nodiscard]] double length() const { return exposure_.close - exposure_.open; }

  /// Leaves of the kernel what its point is there for. False: nothing.
  bool clip_to_lifetime(const Lifetime& life, MovingKernel& kernel) const {
    const double before = kernel.t_mid(), half_before = kernel.half_time();
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
    kernel.keep_part(kernel.t_mid() - before, half_before);
    kernel.color += static_cast<float>(kernel.t_mid() - before) * kernel.color_rate;
    return true;
  }

  /// The filtered disc's as a still of the instant has it: the depth tolerance's unit.
  [[nodiscard]] double size_at(const Instant& instant, const Eigen::Vector3d& center,
                               const Eigen::Vector3d& axis_u, const Eigen::Vector3d& axis_v) const {
    if (!instant.zooms()) return filter_disc(center, axis_u, axis_v, filter_).size;
    PixelFilter filter = filter_;
    filter.radius /= instant.zoom;
    filter.max_tangent_x /= std::min(1.0, instant.zoom);
    filter.max_tangent_y /= std::min(1.0, instant.zoom);
    return filter_disc(instant.as_still(center), instant.as_still(axis_u), instant.as_still(axis_v), filter)
        .size;
  }

  /// Of the depth tolerance, whose unit is the filtered disc's size: it changes as the disc comes nearer, or
  /// grows on the film.
  [[nodiscard]] float tolerance_rate(const PathSegment& path) const {
    // Less is not seen, and to know it exactly would make each kernel dearer.
    constexpr double least = 0.02;
    const double nearest = std::min(path.first.z(), path.last.z()),
                 farthest = std::max(path.first.z(), path.last.z());
    const double first = path.first_u.squaredNorm() + path.first_v.squaredNorm(),
                 last = path.last_u.squaredNorm() + path.last_v.squaredNorm();
    const bool nears = filter_.radius != 0.0 && !filter_.orthographic && farthest - nearest > least * nearest;
    const bool grows = std::abs(last - first) > 2.0 * least * std::min(first, last);
    if (!(nearest > filter_.near) || (!nears && !grows && !path.turns)) return 0.0f;
    const double from = size_at(*path.at_first, path.first, path.first_u, path.first_v),
                 to = size_at(*path.at_last, path.last, path.last_u, path.last_v);
    // As of discs that are large beside the filter, however far they go.
    if (!path.turns && !(std::abs(to - from) > 0.01 * from)) return 0.0f;
    const double change = scene_.model.depth_tolerance * (to - from);
    const auto rate = static_cast<float>(change / (path.end - path.begin));
    return std::isfinite(rate) ? rate : 0.0f;
  }

  /// Returns how far along the view the discs at the ends reach.
  double take_turn(const PathSegment& path, const MovingKernel& kernel, std::optional<DiscTurn>& turn) const {
    const FilteredDisc first = filter_disc(path.first, path.first_u, path.first_v, filter_),
                       last = filter_disc(path.last, path.last_u, path.last_v, filter_);
    const DiscTurn through = turn_through(first, kernel, last);
    const auto content = through.content();
    if (!std::all_of(content.begin(), content.end(), [](float f) { return std::isfinite(f); })) return 0.0;
    turn = through;
    return std::max(std::hypot(first.axis_u.z(), first.axis_v.z()),
                    std::hypot(last.axis_u.z(), last.axis_v.z()));
  }

  /// Even in time between the ends, and right in the mean, as the path is.
  void take_light(std::size_t i, const PathSegment& path, MovingKernel& kernel) const {
    if (!looks_change_) {
      kernel.color = looks_[i];
      return;
    }
    const Eigen::Vector4f chord = path.first_light + 0.5f * (path.last_light - path.first_light);
    kernel.color = chord + (2.0f / 3.0f) * (path.middle_light - chord);
    kernel.color_rate = (path.last_light - path.first_light) / (kernel.t_end - kernel.t_begin);
  }

  /// False: there is none.
  bool fill(std::size_t i, const PathSegment& path, double per_segment, MovingKernel& kernel,
            std::optional<DiscTurn>& turn, KernelCounts& counts) const {
    const Eigen::Vector3d &c0 = path.first, &c1 = path.last, &axis_u = path.axis_u, &axis_v = path.axis_v;
    // While no light comes in.
    if (!(static_cast<float>(path.begin) < static_cast<float>(path.end))) return false;
    kernel.velocity = exposure_.curve ? Eigen::Vector3d((c1 - c0) / (path.end - path.begin))
                                      : Eigen::Vector3d((c1 - c0) * per_segment);
    // As far as the mean of the path lies from that of its chord, by Simpson's rule.
    const Eigen::Vector3d chord = c0 + 0.5 * (c1 - c0);
    kernel.center = chord + (2.0 / 3.0) * (path.middle - chord);
    kernel.t_begin = static_cast<float>(path.begin);
    kernel.t_end = static_cast<float>(path.end);
    if (path.bent) {
      const double half_time = 0.5 * (path.end - path.begin);
      kernel.bend = (chord - path.middle) / (half_time * half_time);
    }

    const FilteredDisc disc = filter_disc(kernel.center, axis_u, axis_v, filter_);
    if (!(static_cast<float>(disc.weight) > 0.0f)) {
      ++counts.culled_degenerate;
      return false;
    }
    double reach = std::hypot(disc.axis_u.z(), disc.axis_v.z());
    kernel.axis_u = disc.axis_u.cast<float>();
    kernel.axis_v = disc.axis_v.cast<float>();
    kernel.weight = static_cast<float>(disc.weight);
    turn.reset();
    if (path.turns) reach = std::max(reach, take_turn(path, kernel, turn));
    if (std::max({c0.z(), c1.z(), path.bent ? path.middle.z() : c0.z()}) + reach < filter_.near) {
      ++counts.culled_near;
      return false;
    }
    const double size =
        path.at_middle->zooms() ? size_at(*path.at_middle, kernel.center, axis_u, axis_v) : disc.size;
    kernel.depth_tolerance = static_cast<float>(scene_.model.depth_tolerance * size);
    kernel.tolerance_rate = tolerance_rate(path);
    kernel.facing.setZero();
    // Coordinates near the end of a double's range, or sizes near that of a float's.
    constexpr float largest = 1e30f;
    if (!kernel.center.allFinite() || !kernel.velocity.allFinite() || !kernel.bend.allFinite() ||
        !kernel.axis_u.allFinite() || !kernel.axis_v.allFinite() || !(kernel.depth_tolerance <= largest)) {
      ++counts.culled_degenerate;
      return false;
    }
    // Normalised before it becomes a float: the product of two tiny axes would underflow.
    const bool oriented = object_.cloud.is_oriented(i);
    if (!object_.two_sided || oriented) {
      const Eigen::Vector3f outside = (side_ * axis_u.cross(axis_v).stableNormalized()).cast<float>();
      if (!object_.two_sided) kernel.facing = outside;
      if (oriented) kernel.outside = outside;
    }
    take_light(i, path, kernel);
    if (!object_.cloud.lifetime.empty() && !clip_to_lifetime(object_.cloud.lifetime[i], kernel)) return false;
    if (kernel.still()) ++counts.still_kernels;
    const Eigen::Vector3d normal = axis_u.cross(axis_v);
    const bool edge_on = filter_.orthographic ? std::abs(normal.z()) < 1e-3 * normal.norm()
                                              : std::abs(normal.dot(kernel.center)) <
                                                    1e-3 * normal.norm() * kernel.center.norm();
    if (edge_on) ++counts.edge_on_kernels;
    if (std::min({c0.z(), c1.z(), path.bent ? path.middle.z() : c0.z()}) - reach < filter_.near)
      ++counts.near_kernels;
    return true;
  }

  const Scene& scene_;
  const Object& object_;
  Exposure exposure_, all_;  ///< of the top row, and of all rows
  PixelFilter filter_;
  bool looks_change_;
  LooksAt looks_;  ///< in the middle of the exposure
  bool still_;     ///< known once: rates that are all zero have to be looked through
  double tolerance_, begin_ = 0.0, scale_ = 1.0;
  double side_ = 1.0;  ///< −1: the object is mirrored
  std::optional<PathCutter> cutter_;
  std::optional<AlikePaths> alike_;
};

KernelMaker::KernelMaker(const Scene& scene, const Exposure& exposure, SegmentShape shape)
    : scene_(scene),
      exposure_(exposure),
      projection_(
          projection_of(scene.film, scene.camera.at(exposure.of_all_rows(scene.film.height).middle()))),
      near_(scene.camera.near) {
  std::size_t points = 0;
  for (const Object& object : scene.objects) {
    first_point_.push_back(points);
    points += object.discs();
    objects_.push_back(object.discs() == 0
                           ? nullptr
                           : std::make_unique<ObjectKernels>(scene, object, exposure, projection_, shape));
  }
}

KernelMaker::~KernelMaker() = default;
KernelMaker::KernelMaker(KernelMaker&&) noexcept = default;

std::size_t KernelMaker::expected() {
  std::size_t kernels = 0;
  for (const auto& object : objects_)
    if (object) kernels += object->expected();
  return kernels;
}

KernelCounts KernelMaker::make_all(const Visit& visit, const std::stop_token& stop) {
  KernelCounts counts;
  for (std::size_t k = 0; k < objects_.size(); ++k) {
    if (!objects_[k]) continue;
    counts.surfels += scene_.objects[k].discs();
    objects_[k]->make_all(first_point_[k], visit, stop, counts);
  }
  return counts;
}

MovingKernel KernelMaker::make(const KernelSource& source, std::optional<DiscTurn>& turn) const {
  // The last object that begins there: those before it that do have no points.
  const auto next = std::upper_bound(first_point_.begin(), first_point_.end(), std::size_t{source.point});
  const auto k = static_cast<std::size_t>(next - first_point_.begin()) - 1;
  return objects_[k]->make(source.point - first_point_[k], source.piece, turn);
}

}  // namespace swept
