// The exponential of the sampled engine: worst error of the plain loops' text, in units of the last place.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <gtest/gtest.h>

#include "abuffer/simd/vector_scalar.h"

#include "abuffer/simd/sampled_math_text.h"

// Uses what the text defines besides.
SWEPT_DEFINE_SAMPLED_MATH(sampled_math_tested, "tested")

namespace swept {
namespace {

struct Worst {
  double ulp = 0.0;
  float at = 0.0f;
};

/// Over every float of [low, high] ≤ 0 but for `step` − 1 of `step`.
Worst worst_between(float low, float high, std::uint32_t step) {
  Worst worst;
  std::uint32_t first, last;
  std::memcpy(&first, &high, sizeof first);
  std::memcpy(&last, &low, sizeof last);
  for (std::uint64_t word = first; word <= last; word += step) {
    const auto narrow = static_cast<std::uint32_t>(word);
    float x;
    std::memcpy(&x, &narrow, sizeof x);
    const long double truth = std::exp(static_cast<long double>(x));
    const long double unit = std::ldexp(1.0L, std::max(-149, std::ilogb(static_cast<double>(truth)) - 23));
    const double ulp =
        static_cast<double>(std::abs(static_cast<long double>(exp_of(all(x)).x) - truth) / unit);
    if (!(ulp <= worst.ulp)) worst = {ulp, x};
  }
  return worst;
}

TEST(SampledExp, IsWithinAnUlp) {
  struct Range {
    float low, high;
    std::uint32_t step;
  };
  for (const Range& range : {Range{-1e-3f, -1e-30f, 4999}, Range{-1.0f, -1e-3f, 97}, Range{-50.0f, -1.0f, 61},
                             Range{-80.0f, -50.0f, 61}}) {
    const Worst worst = worst_between(range.low, range.high, range.step);
    EXPECT_LE(worst.ulp, 1.0) << "at " << worst.at;
  }
}

TEST(SampledExp, OfNothingIsOneAndNeverMore) {
  EXPECT_EQ(exp_of(all(0.0f)).x, 1.0f);
  EXPECT_EQ(exp_of(all(-0.0f)).x, 1.0f);
  float x = -1e-30f;
  for (int i = 0; i < 400; ++i, x *= 1.3f)
    if (x > -80.0f) {
      EXPECT_LE(exp_of(all(x)).x, 1.0f) << x;
      EXPECT_GT(exp_of(all(x)).x, 0.0f) << x;
    }
}

}  // namespace
}  // namespace swept
