// Which pixels may see what stays within a hull of points, through a lens too.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "abuffer/sources/rasterize.h"
#include "abuffer/stochastic/enclosure.h"
#include "abuffer/stochastic/pixel_samples.h"
#include "splat/camera.h"

namespace swept::stochastic {

/// Pixels [x0, x1) × [y0, y1) of the film.
struct PixelRange {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  [[nodiscard]] bool empty() const { return x0 >= x1 || y0 >= y1; }
};
[[nodiscard]] inline PixelRange range_of(const Window& window) {
  return {window.x, window.y, window.x + window.width, window.y + window.height};
}
[[nodiscard]] inline PixelRange meet(const PixelRange& a, const PixelRange& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}
[[nodiscard]] inline PixelRange join(const PixelRange& a, const PixelRange& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

/// What bounds are in, the same for a whole render.
struct FilmView {
  Projection projection;
  double near = 0.0;
  LensReach lens;

  /// A point whose direction from an eye tells where it is on the film: of an orthographic camera its shadow
  /// at depth 1.
  [[nodiscard]] Eigen::Vector3d seen(const Eigen::Vector3d& p) const {
    return projection.orthographic ? Eigen::Vector3d(p.x(), p.y(), 1.0) : p;
  }

  /// The time in which something may be on the inner side of the plane of the eye's rays at `tangent`, of
  /// the upper (`side` 1) or lower ones of `axis`, seen through the lens. `within(γ, c)` is that in which it
  /// may be on the inner side of the plane of slope γ that lies c farther out. Rays through the lens reach
  /// R|1 − z/F| beyond the tile's side at depth z, and what is outside is beyond both lines of it. F may
  /// change.
  template <class Within>
  [[nodiscard]] Span inside(int axis, int side, double tangent, const Within& within) const {
    const double reach = axis == 0 ? lens.x : lens.y;
    if (!(reach > 0.0)) return within(tangent, 0.0);
    Span span{1.0, 0.0};
    for (const double inverse_focus : {lens.least_inverse_focus, lens.most_inverse_focus}) {
      const double turn = (side == 1 ? 1.0 : -1.0) * reach * inverse_focus;
      span = join(span, within(tangent - turn, reach));
      span = join(span, within(tangent + turn, -reach));
    }
    return span;
  }
};

/// The film's places at which rays may meet points of a convex hull. A hull that crosses the near plane may
/// be anywhere.
class HullBounds {
 public:
  explicit HullBounds(const FilmView& view) : view_(view) {}

  void include(const Eigen::Vector3d& p) {
    // A little nearer counts as at it, for rounding.
    const bool in_front = p.z() >= view_.near * (1.0 - 1e-9);
    (in_front ? in_front_ : behind_) = true;
    if (!in_front && !view_.projection.orthographic) return;
    const double inverse = 1.0 / view_.projection.divisor(p.z()), x = p.x() * inverse, y = p.y() * inverse;
    x_min_ = std::min(x_min_, x), x_max_ = std::max(x_max_, x);
    y_min_ = std::min(y_min_, y), y_max_ = std::max(y_max_, y);
    z_min_ = std::min(z_min_, p.z()), z_max_ = std::max(z_max_, p.z());
  }

  /// Those of `window`. `inset`: 0 for places anywhere in a pixel, ½ for its centre.
  [[nodiscard]] PixelRange pixels(const PixelRange& window, double inset) const {
    if (!in_front_) return {};
    if (behind_ && !view_.projection.orthographic) return window;
    if (!std::isfinite((x_max_ - x_min_) + (y_max_ - y_min_))) return window;
    const LensReach& lens = view_.lens;
    const auto pad = [&](double reach) {
      return lens.any() ? std::max(lens.tangent(reach, z_min_), lens.tangent(reach, z_max_)) : 0.0;
    };
    const double f = view_.projection.focal_px, x_pad = pad(lens.x), y_pad = pad(lens.y);
    const auto clamped = [](double v, int low, int high) {
      return static_cast<int>(std::clamp(v, static_cast<double>(low), static_cast<double>(high)));
    };
    constexpr double margin = 1e-3;  // px, for rounding
    const auto first = [&](double tangent, double center, int low, int high) {
      return clamped(std::floor(center + f * tangent - margin + inset), low, high);
    };
    const auto end = [&](double tangent, double center, int low, int high) {
      return clamped(std::floor(center + f * tangent + margin - inset) + 1.0, low, high);
    };
    const Projection& film = view_.projection;
    return {first(x_min_ - x_pad, film.center_x, window.x0, window.x1),
            first(y_min_ - y_pad, film.center_y, window.y0, window.y1),
            end(x_max_ + x_pad, film.center_x, window.x0, window.x1),
            end(y_max_ + y_pad, film.center_y, window.y0, window.y1)};
  }

 private:
  const FilmView& view_;
  bool in_front_ = false, behind_ = false;
  double x_min_ = HUGE_VAL, x_max_ = -HUGE_VAL, y_min_ = HUGE_VAL, y_max_ = -HUGE_VAL;
  double z_min_ = HUGE_VAL, z_max_ = -HUGE_VAL;
};

}  // namespace swept::stochastic
