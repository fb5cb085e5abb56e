// Cutting one point's path through camera space into linear segments, as many as it needs itself (model
// section 7). Source: Gribel et al. 2013, section 5, which cuts by a tolerance on the film.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "splat/export.h"
#include "splat/kernel/moving_kernel.h"
#include "splat/motion/instant.h"
#include "splat/motion/look.h"

namespace SWEPT_API swept {

/// A stretch of a point's path, camera space. Times are shares of the light, 0 to 1.
struct PathSegment {
  double begin = 0.0, end = 1.0;
  Eigen::Vector3d first, middle, last;  ///< centres
  Eigen::Vector3d axis_u, axis_v;       ///< in the middle
  bool bent = false;                    ///< a parabola through the three
  bool turns = false;                   ///< axes, too, and those of the pixel filter
  /// Premultiplied; where looks_change() over the exposure, else not set.
  Eigen::Vector4f first_light = Eigen::Vector4f::Zero(), middle_light = first_light, last_light = first_light;
  /// Axes at the ends.
  Eigen::Vector3d first_u = Eigen::Vector3d::Zero(), first_v = first_u, last_u = first_u, last_v = first_u;
  const Instant *at_first = nullptr, *at_middle = nullptr, *at_last = nullptr;  ///< of who cut it
  std::uint32_t piece = 0;  ///< which of all that the path may be cut into
};

/// What a path is cut into.
enum class SegmentShape {
  chords,
  /// Where they turn by little and each ray sees a small part of one (kernel/bent_kernel.h); and of axes,
  /// where discs turn, grow or come nearer (kernel/turning_kernel.h).
  parabolas,
};

/// Cuts the points of one object.
class PathCutter {
 public:
  /// The scene and the object must outlive it. Segments run over `exposure`, all rows alike.
  PathCutter(const Scene& scene, const Object& object, const Exposure& exposure,
             SegmentShape shape = SegmentShape::chords);

  /// The segments of point `i`, in order: a single one where no chord of the path, looked at in the middle
  /// and half-way to it, is farther from it than `tolerance_px` on the film and no rim farther than 0.75
  /// times that from where it is in the middle (rims.h); else halves of it, down to 256 between two corners
  /// of the path. Nor is the pixel filter of the middle 0.6 times that from the one where it is used, nor, of
  /// parabolas, the filtered disc from what it is seen from elsewhere.
  /// Looks that change may be 2⁻⁹ of themselves, or of 1, off their chord. Of parabolas it is what they are
  /// off by half-way to the middle that may be as much, and the chord's error there times the square of what
  /// part of the time a ray sees the disc for. Where axes are parabolas it is so with rims and filters, while
  /// the disc shows one side. Valid until the next call. Not for several threads at once.
  const std::vector<PathSegment>& cut(std::size_t i, double tolerance_px);

  /// A segment that cut() has once returned of this point at the tolerance of its last call, to the bit. For
  /// any threads, while none cuts.
  [[nodiscard]] PathSegment segment(std::size_t i, std::uint32_t piece) const;

 private:
  struct Place {
    Instant instant;
    SurfelsAt surfels;
    LooksAt looks;
  };
  struct Seen {
    Eigen::Vector3d center, axis_u, axis_v;
    Eigen::Vector4f light;  ///< where looks change
    const Instant* at;
  };
  static constexpr int finest = 10;  ///< halvings of a span at which paths are looked at
  static constexpr int most_halvings = 8;

  [[nodiscard]] double time(std::size_t span, int index) const;
  [[nodiscard]] Place place(double time) const;
  [[nodiscard]] Seen see(std::size_t i, const Place& place) const;
  const Place& at(std::size_t span, int index);
  [[nodiscard]] const Place& known(std::size_t span, int index) const;
  [[nodiscard]] bool same_light(const Seen& first, const Seen& truth, const Seen& last, double share) const;
  [[nodiscard]] bool near_line(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] bool near_path(const Seen& first, const Seen& middle, const Seen& last, const Seen& truth,
                               double share) const;
  [[nodiscard]] Eigen::Vector2d ray_of(const Eigen::Vector3d& center) const;
  [[nodiscard]] double way_px(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] bool bends(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] double seen_share(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] bool near_middle(const Seen& end, const Seen& middle, double part = 1.0) const;
  [[nodiscard]] bool same_filter(const Seen& end, const Seen& middle, double part) const;
  [[nodiscard]] bool same_from_the_side(const Seen& end, const Seen& middle, double part) const;
  [[nodiscard]] FilteredDisc filtered(const Seen& seen, const FilteredDisc* towards) const;
  struct Axes;
  [[nodiscard]] bool keeps_axes(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] bool may_turn(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] bool turns(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] PathSegment segment_of(const std::pair<double, double>& times, const Seen& first,
                                       const Seen& middle, const Seen& last, std::uint32_t piece) const;
  [[nodiscard]] bool shows_one_side(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] Axes axes_of(const Seen& first, const Seen& middle, const Seen& last) const;
  [[nodiscard]] bool near_axes(const Axes& axes, const Seen& middle, const Seen& truth, double share) const;
  [[nodiscard]] double visible_scale(const Eigen::Vector3d& center) const;
  bool is_one_segment(std::size_t i);
  void halve(std::size_t i, std::size_t span, int begin, int end, const Seen& first, const Seen& last);
  void add_corners();

  const Scene& scene_;
  const Object& object_;
  Exposure exposure_;
  SegmentShape shape_;
  Projection projection_;
  PixelFilter filter_;
  bool looks_change_;
  double tolerance_px_ = 0.1;
  std::vector<double> spans_;  ///< 0, corners, 1
  /// By span, at 2¹⁰ + 1 times, coarsest first, as far as asked for.
  std::vector<std::vector<std::unique_ptr<Place>>> looks_;
  Place middle_;
  std::vector<PathSegment> segments_;
};

/// Whether build_kernels() cuts `object` point by point, and not all points alike.
[[nodiscard]] bool cuts_by_point(const Scene& scene, const Object& object, const Exposure& exposure);

/// The tolerance that it does so with, px.
[[nodiscard]] double path_tolerance_px(const Scene& scene);

}  // namespace swept
