#include "abuffer/splats/splat_estimate.h"

#include <algorithm>
#include <cmath>

namespace swept {

SplatEstimate::SplatEstimate(const SplatSquares& squares, int count) {
  const double scale = 1.0 / (double{1.0} * count * count);
  alternating_ = squares.alternating * scale;
  grey_ = squares.grey * scale;
  // Fewer instants than this show no second frequency.
  constexpr int least = 4;
  extrapolate(count < least || squares.quarter == 0.0 ? 0.25 : 0.5 * squares.grey / squares.quarter, count);
}

void SplatEstimate::refine(const SplatSquares& squares, int count) {
  const double before = grey_, scale = 1.0 / (double{1.0} * count * count);
  alternating_ = squares.alternating * scale;
  grey_ = squares.grey * scale;
  extrapolate(before > 0.0 ? grey_ / before : 0.25, count);
}

/// `falls_by`: F²(N/2) over F²(N/4).
void SplatEstimate::extrapolate(double falls_by, int count) {
  // Of a jump all multiples of N count, Σ1/k² = π²/6, where the sums see the odd ones of N/2, π²/8.
  constexpr double multiples = 4.0 / 3.0;
  // Passing bells fall faster and faster. Splats that change their order are jumps, which fall by 4; nothing
  // seen so far tells when they begin to lead.
  const double least_fall = count < 4 ? 0.2 : 0.15;
  const double share = multiples * std::clamp(falls_by, least_fall, 1.0);
  squares_ = share * alternating_;
  per_alternating_ = share / (double{1.0} * count * count);
}

}  // namespace swept
