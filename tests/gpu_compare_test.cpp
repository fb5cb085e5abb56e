// The comparator of the GPU tests finds what is planted for it.
#include "gpu_compare.h"

#include <limits>

namespace swept {
namespace {

constexpr Band band{1e-4, 0.01};

std::vector<float> ramp() {
  std::vector<float> values(4 * 1000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 97) / 97.0f;
  return values;
}

/// Noise of both signs in every value.
std::vector<float> with_noise(std::vector<float> values, float amplitude) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += (i / 4 % 2 == 0 ? amplitude : -amplitude);
  return values;
}

TEST(GpuCompare, AcceptsRoundingAndAFewFlips) {
  EXPECT_TRUE(equal_within(ramp(), ramp(), 4, band));
  std::vector<float> values = with_noise(ramp(), 0.9e-4f);
  for (std::size_t p = 0; p < 10; ++p) values[400 * p] += 0.3f;
  EXPECT_TRUE(equal_within(values, ramp(), 4, band));
}

TEST(GpuCompare, FindsTooManyFlips) {
  std::vector<float> values = ramp();
  for (std::size_t p = 0; p < 11; ++p) values[400 * p / 11 * 4] += 1.1e-4f;
  EXPECT_FALSE(equal_within(values, ramp(), 4, band));
}

TEST(GpuCompare, FindsABiasBelowTheTolerance) {
  std::vector<float> values = ramp();
  for (float& value : values) value += 0.3e-4f;
  EXPECT_FALSE(equal_within(values, ramp(), 4, band));
}

TEST(GpuCompare, FindsNoiseAboveTheTolerance) {
  EXPECT_FALSE(equal_within(with_noise(ramp(), 1.2e-4f), ramp(), 4, band));
}

TEST(GpuCompare, FindsWhatIsNoNumberAndWhatIsMissing) {
  std::vector<float> values = ramp();
  values[77] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(equal_within(values, ramp(), 4, band));
  values = ramp();
  values.resize(values.size() - 4);
  EXPECT_FALSE(equal_within(values, ramp(), 4, band));
  EXPECT_FALSE(equal_within(ramp(), ramp(), 4, band, [](std::size_t) { return false; }));
}

TEST(GpuCompare, TakesEqualInfinitiesAsEqual) {
  const std::vector<double> infinite(8, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(equal_within(infinite, infinite, 1, band));
}

}  // namespace
}  // namespace swept
