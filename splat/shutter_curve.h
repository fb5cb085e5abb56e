// How much light the shutter lets in over the exposure, and the map between time and shares of the light.
//
// With a(τ) the rate, ∫a = 1, and s(τ) = ∫₀^τ a the share of the light that is in by τ, a pixel is
// ∫a(τ)C(τ)dτ = ∫C(τ(s))ds: a curve is a warp of time, and whatever is averaged or integrated evenly over
// shares of the light has the curve's own weights. Source: model section 1; Heinzle et al. 2010 for the
// Gaussian.
#pragma once

#include <vector>

#include "splat/export.h"

namespace SWEPT_API swept {

struct Shutter;

class ShutterCurve {
 public:
  /// Precondition: the shutter is valid, and its shape is not `box`, which needs no curve.
  explicit ShutterCurve(const Shutter& shutter);

  /// The share of the light that has come in by `time`; both in [0, 1], 0 being where the shutter opens.
  [[nodiscard]] double share(double time) const;
  /// The time by which `share` of the light has come in: the inverse. Where no light comes in, the first such
  /// time.
  [[nodiscard]] double time(double share) const;

 private:
  // A Gaussian exp(−δ(2τ − 1)²), where delta_ > 0; else lines between rates at times.
  double delta_ = 0.0;
  std::vector<double> times_, rates_, shares_;
};

}  // namespace swept
