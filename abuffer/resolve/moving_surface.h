// What the sweep over discs hands to who puts their surfaces among others.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "splat/interval/composite.h"
#include "splat/interval/ticks.h"

namespace swept {

/// A disc of a surface, in shares of the exposure after the piece's begin.
struct SurfaceMember {
  double y, rate, peak;  ///< ρ = peak · exp(−(y + rate·τ)²)
  double z, z_rate;
  double rgba[4], rgba_rate[4];
};

/// A surface over a piece of time.
struct MovingSurface {
  /// Of the members that it has all the time; or none, where it is as these straight lines say.
  std::span<const SurfaceMember> members;
  double rgba[4] = {0.0, 0.0, 0.0, 0.0};   ///< premultiplied, times coverage: in the piece's middle
  double swing[4] = {0.0, 0.0, 0.0, 0.0};  ///< and by how much more at its end
  double z_begin = 0.0, z_end = 0.0;       ///< depth at the piece's ends

  struct Look {
    double rgba[4], depth;
  };
  /// At a time of the piece, a share of the exposure after its begin, and of the piece.
  [[nodiscard]] Look at(const SurfaceModel& model, double since, double of_piece) const {
    Look look{{}, z_begin + of_piece * (z_end - z_begin)};
    for (int c = 0; c < 4; ++c) look.rgba[c] = rgba[c] + (2.0 * of_piece - 1.0) * swing[c];
    if (members.empty()) return look;
    double weight = 0.0, depth = 0.0, sums[4] = {0.0, 0.0, 0.0, 0.0};
    for (const SurfaceMember& m : members) {
      const double y = m.y + m.rate * since, rho = m.peak * std::exp(-y * y);
      weight += rho;
      depth += rho * (m.z + m.z_rate * since);
      for (int c = 0; c < 4; ++c) sums[c] += rho * (m.rgba[c] + since * m.rgba_rate[c]);
    }
    if (!(weight >= double{std::numeric_limits<float>::min()})) return {{}, members.front().z};
    const double divisor = model.hard() ? weight : std::max(weight, double{model.edge_weight()});
    for (int c = 0; c < 4; ++c) look.rgba[c] = sums[c] / divisor;
    look.depth = depth / weight;
    return look;
  }
  /// Through the values at Gauss's two points.
  [[nodiscard]] static MovingSurface line(const SurfaceModel& model, const SurfaceSum& mean,
                                          const SurfaceSum& swing, const DepthSpan& span) {
    constexpr double root_three = 1.7320508075688772;
    const SurfaceSum points[2] = {at_point(mean, swing, -1.0f), at_point(mean, swing, 1.0f)};
    const float scales[2] = {model.scale(points[0]), model.scale(points[1])};
    MovingSurface line;
    line.z_begin = span.from, line.z_end = span.to;
    for (int c = 0; c < 4; ++c) {
      const double before = double{points[0].rgba[c]} * double{scales[0]},
                   after = double{points[1].rgba[c]} * double{scales[1]};
      line.rgba[c] = 0.5 * (before + after);
      line.swing[c] = 0.5 * root_three * (after - before);
    }
    return line;
  }
};

/// Takes the surfaces of a pixel's discs instead of their light. It says where pieces of time must end.
class PieceSink {
 public:
  virtual ~PieceSink() = default;
  /// What discs show from `begin` to `end`, front to back, until no light is left. Pieces come in the order
  /// of time and do not overlap; where there is none discs show nothing.
  virtual void piece(Ticks begin, Ticks end, std::span<const MovingSurface> surfaces) = 0;
  /// When a piece that begins at `begin` must end at the latest: after it. `begin` never decreases.
  [[nodiscard]] virtual Ticks end_after(Ticks begin) = 0;
  /// Where surfaces that are nearer all the time need not be known instant by instant.
  [[nodiscard]] virtual float nearest() const = 0;
};

}  // namespace swept
