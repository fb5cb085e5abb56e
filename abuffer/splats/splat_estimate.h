// What a cell of N instants is off by, as its alternating sums show it.
#pragma once

#include "abuffer/splats/splat_cell.h"

namespace swept {

/// As ErrorEstimate, of N midpoints and after doublings: the alternating sums show the amplitude F of the
/// signal's frequency N/2, those of every other instant F(N/4), and the error is √2 F(N). What fell from N/4
/// to N/2 falls as much again to N.
class SplatEstimate {
 public:
  SplatEstimate(const SplatSquares& squares, int count);
  /// After the instants were doubled to `count`, and the alternating sums with them.
  void refine(const SplatSquares& squares, int count);

  /// Expected, Σ over pixels and R, G, B.
  [[nodiscard]] double squares() const { return squares_; }
  /// How much of it there is for every square of an alternating sum.
  [[nodiscard]] double per_alternating() const { return per_alternating_; }

 private:
  void extrapolate(double falls_by, int count);

  double alternating_ = 0.0, grey_ = 0.0, squares_ = 0.0, per_alternating_ = 0.0;
};

}  // namespace swept
