#include "abuffer/interval_math.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "splat/kernel_integral.h"

namespace swept {
namespace {

/// exp(x) for x ∈ [−87, 0], without a branch, so that the compiler vectorises the loop around it. Argument
/// reduction by ln 2 in two parts (Cody and Waite); a Taylor polynomial of degree 6 on |r| ≤ ln(2)/2
/// leaves 1.2e-7·2⁻⁶.
inline float exp_negative(float x) {
  constexpr float round_to_integer = 0x1.8p23f;
  const float clamped = x < -87.0f ? -87.0f : x;
  const float shifted = clamped * 1.44269504f + round_to_integer;
  const float n = shifted - round_to_integer;
  const float r = (clamped - n * 0x1.62e4p-1f) - n * 0x1.7f7d1cp-20f;
  float p = 1.0f / 720.0f;
  p = p * r + 1.0f / 120.0f;
  p = p * r + 1.0f / 24.0f;
  p = p * r + 1.0f / 6.0f;
  p = p * r + 0.5f;
  p = p * r + 1.0f;
  p = p * r + 1.0f;
  const std::int32_t exponent = std::bit_cast<std::int32_t>(shifted) << 23;
  return std::bit_cast<float>(std::bit_cast<std::int32_t>(p) + exponent);
}

}  // namespace

void weighted_means(const float* y, const float* span, const float* peak, float* mean, std::size_t count) {
  bool all_short = true;
  for (std::size_t i = 0; i < count; ++i) {
    const float middle = y[i] + 0.5f * span[i];
    mean[i] = peak[i] * exp_negative(-middle * middle) * GaussianSeries<float>::factor(middle, span[i]);
    all_short &= GaussianSeries<float>::holds(middle, span[i]);
  }
  if (all_short) return;
  for (std::size_t i = 0; i < count; ++i)
    if (!GaussianSeries<float>::holds(y[i] + 0.5f * span[i], span[i]))
      mean[i] = peak[i] * mean_gaussian(y[i], y[i] + span[i]);
}

}  // namespace swept
