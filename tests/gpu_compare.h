// Two images that should differ by rounding alone: tight everywhere, but for a capped share of pixels in
// which rounding put a fragment on the other side of a cut-off, and without a bias.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

namespace swept {

struct Band {
  double tolerance = 0.0;      ///< absolute, each value
  double flipped_share = 0.0;  ///< of the pixels, that may exceed it
};

/// Compares pixels of `channels` values each, those for which `counts` is true.
///
/// Signs of rounding errors are even, so the mean signed difference of all values within the tolerance has to
/// be well below it: a quarter lets an error of that size pass only where it touches few of them.
template <class A, class B>
[[nodiscard]] testing::AssertionResult equal_within(const std::vector<A>& actual,
                                                    const std::vector<B>& expected, std::size_t channels,
                                                    const Band& band,
                                                    const std::function<bool(std::size_t)>& counts = {}) {
  if (actual.size() != expected.size() || actual.size() % channels != 0)
    return testing::AssertionFailure() << actual.size() << " values, expected " << expected.size();
  std::size_t pixels = 0, flipped = 0, worst_pixel = 0, values = 0;
  double worst = 0.0, sum = 0.0;
  for (std::size_t p = 0; p < actual.size() / channels; ++p) {
    if (counts && !counts(p)) continue;
    ++pixels;
    double largest = 0.0, signed_sum = 0.0;
    for (std::size_t i = channels * p; i < channels * (p + 1); ++i) {
      const double a = static_cast<double>(actual[i]), b = static_cast<double>(expected[i]);
      const double difference = a == b ? 0.0 : a - b;
      if (std::isnan(difference)) return testing::AssertionFailure() << "pixel " << p << " is not a number";
      largest = std::max(largest, std::abs(difference));
      signed_sum += difference;
    }
    if (largest > worst) worst = largest, worst_pixel = p;
    if (largest > band.tolerance) {
      ++flipped;
      continue;
    }
    sum += signed_sum;
    values += channels;
  }
  if (pixels == 0) return testing::AssertionFailure() << "no pixel counts";
  const double allowed = band.flipped_share * static_cast<double>(pixels);
  if (static_cast<double>(flipped) > allowed)
    return testing::AssertionFailure()
           << flipped << " of " << pixels << " pixels differ by more than " << band.tolerance << ", at most "
           << allowed << " may; worst " << worst << " at pixel " << worst_pixel;
  const double bias = values > 0 ? std::abs(sum) / static_cast<double>(values) : 0.0;
  if (bias > 0.25 * band.tolerance)
    return testing::AssertionFailure()
           << "values differ by " << bias << " on average, with tolerance " << band.tolerance;
  return testing::AssertionSuccess() << "worst " << worst << ", " << flipped << " of " << pixels
                                     << " flipped";
}

}  // namespace swept
