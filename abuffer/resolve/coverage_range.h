// Between what Σρ of a surface stays over a piece of time, and what that says of its soft coverage,
// min(1, Σρ/ρ_edge), whose clamp is not linear.
#pragma once

#include <algorithm>

namespace swept {

struct CoverageRange {
  float low, high;  ///< of Σρ

  /// By the mean, the most that members vary by, and the sum of their peaks.
  [[nodiscard]] static CoverageRange of_members(float mean, float variation, float peaks) {
    return {mean - variation, std::min(mean + 2.0f * variation, peaks)};
  }
  /// Of the parabola over the piece with these ends and this mean: its extremum is where Σρ has its own, if
  /// that has one within.
  [[nodiscard]] static CoverageRange of_parabola(float at_begin, float mean, float at_end) {
    const float slope = 6.0f * mean - 4.0f * at_begin - 2.0f * at_end;
    const float curvature = 3.0f * (at_begin + at_end - 2.0f * mean);
    const float vertex = -0.5f * slope / curvature;
    const float extremum = vertex > 0.0f && vertex < 1.0f ? at_begin + 0.5f * slope * vertex : at_begin;
    return {std::min({at_begin, extremum, at_end}), std::max({at_begin, extremum, at_end})};
  }

  /// The pixel is covered all along; or nowhere clamped.
  [[nodiscard]] bool covers(float edge) const { return low >= edge; }
  [[nodiscard]] bool linear(float edge) const { return high <= edge; }
  /// Whether the mean tells how much is clamped, over a share `duration` of the exposure. The mean of the
  /// clamped differs from the clamped mean by at most a quarter of the range, whatever its shape.
  [[nodiscard]] bool settled(float edge, double duration) const {
    return covers(edge) || linear(edge) || double{high - low} * duration <= most_spread(edge);
  }
  /// What Σρ may vary by, times the share of the exposure: of the exposure the clamp may be off by 2⁻¹⁵.
  [[nodiscard]] static double most_spread(float edge) { return 4.0 * double{edge} * 0x1p-15; }
};

}  // namespace swept
