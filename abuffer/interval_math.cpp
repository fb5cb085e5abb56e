#include "abuffer/interval_math.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "splat/kernel_integral.h"

// One text for every instruction set. There is no contraction and every sum has a fixed order, so all give
// the same bits.
#if defined(SWEPT_SIMD_CLONES)
#define SWEPT_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define SWEPT_CLONES
#endif

namespace swept {
namespace {

/// exp(x) for x ∈ [−87, 0] without a branch, so that the loop around it becomes vectors. Argument reduction
/// by ln 2 in two parts (Cody and Waite); the Taylor polynomial of degree 6 on |r| ≤ ln(2)/2 is off by 1.2e-7
/// · 2⁻⁶.
inline float exp_negative(float x) {
  constexpr float round_to_integer = 0x1.8p23f;
  const float shifted = x * 1.44269504f + round_to_integer;
  const float n = shifted - round_to_integer;
  const float r = (x - n * 0x1.62e4p-1f) - n * 0x1.7f7d1cp-20f;
  float p = 1.0f / 720.0f;
  p = p * r + 1.0f / 120.0f;
  p = p * r + 1.0f / 24.0f;
  p = p * r + 1.0f / 6.0f;
  p = p * r + 0.5f;
  p = p * r + 1.0f;
  p = p * r + 1.0f;
  const std::uint32_t exponent = std::bit_cast<std::uint32_t>(shifted) << 23;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(p) + exponent);
}

/// Where GaussianSeries<float>::factor keeps its error below 2⁻²⁴: the first term dropped is at most
/// (m s)¹⁰/11! + s¹⁰/(4⁵·5!·11) ≤ 2.6e-8.
inline bool series_holds(float middle, float span) { return span <= 0.5f && span * std::abs(middle) <= 1.0f; }

/// One accumulator per lane, added up in a fixed order.
struct LaneSum {
  float lane[member_lanes] = {};

  [[nodiscard]] float total() const {
    static_assert(member_lanes == 8);
    return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
  }
  [[nodiscard]] float largest() const {
    float value = lane[0];
    for (float other : lane) value = other > value ? other : value;
    return value;
  }
};

}  // namespace

SWEPT_CLONES
DepthRange depths_over(const Members& members, float begin, float end, float* z_begin, float* z_end) {
  const float *t = members.field(member_t_begin), *z = members.field(member_z),
              *rate = members.field(member_z_rate), *tolerance = members.field(member_tolerance),
              *speed = members.field(member_rate);
  for (std::size_t i = 0; i < members.padded; ++i) {
    z_begin[i] = z[i] + rate[i] * (begin - t[i]);
    z_end[i] = z[i] + rate[i] * (end - t[i]);
  }
  // Largest of the values and of their opposites.
  LaneSum high_begin, low_begin, high_end, low_end, high_tolerance, low_tolerance, high_rate;
  const auto start = [](LaneSum& sum, float value) {
    for (float& lane : sum.lane) lane = value;
  };
  start(high_begin, z_begin[0]);
  start(low_begin, -z_begin[0]);
  start(high_end, z_end[0]);
  start(low_end, -z_end[0]);
  start(high_tolerance, tolerance[0]);
  start(low_tolerance, -tolerance[0]);
  const auto raise = [](float& lane, float value) { lane = value > lane ? value : lane; };
  for (std::size_t i = 0; i < members.padded; i += member_lanes)
    for (std::size_t l = 0; l < member_lanes; ++l) {
      raise(high_begin.lane[l], z_begin[i + l]);
      raise(low_begin.lane[l], -z_begin[i + l]);
      raise(high_end.lane[l], z_end[i + l]);
      raise(low_end.lane[l], -z_end[i + l]);
      raise(high_tolerance.lane[l], tolerance[i + l]);
      raise(low_tolerance.lane[l], -tolerance[i + l]);
      raise(high_rate.lane[l], speed[i + l]);
    }
  return {-low_begin.largest(),     high_begin.largest(),     -low_end.largest(), high_end.largest(),
          -low_tolerance.largest(), high_tolerance.largest(), high_rate.largest()};
}

SWEPT_CLONES
MemberSum sum_over(const Members& members, float begin, float end, float* mean) {
  const float *t = members.field(member_t_begin), *y = members.field(member_y),
              *rate = members.field(member_rate), *peak = members.field(member_peak),
              *z = members.field(member_z), *z_rate = members.field(member_z_rate);
  const float duration = end - begin, middle_time = 0.5f * (begin + end);
  std::uint32_t long_spans = 0;
  for (std::size_t i = 0; i < members.padded; ++i) {
    const float middle = y[i] + rate[i] * (middle_time - t[i]);
    const float span = rate[i] * duration;
    mean[i] = peak[i] * exp_negative(-middle * middle) * GaussianSeries<float>::factor(middle, span);
    long_spans += series_holds(middle, span) ? 0u : 1u;
  }
  if (long_spans > 0)
    for (std::size_t i = 0; i < members.count; ++i) {
      const float middle = y[i] + rate[i] * (middle_time - t[i]);
      const float span = rate[i] * duration;
      if (!series_holds(middle, span))
        mean[i] = peak[i] * mean_gaussian(middle - 0.5f * span, middle + 0.5f * span);
    }

  const float *red_of = members.field(member_red), *green_of = members.field(member_green),
              *blue_of = members.field(member_blue), *alpha_of = members.field(member_alpha);
  LaneSum weight, red, green, blue, alpha, depth, variation, peaks, widest;
  for (std::size_t i = 0; i < members.padded; i += member_lanes)
    for (std::size_t l = 0; l < member_lanes; ++l) {
      const std::size_t k = i + l;
      const float m = mean[k];
      const float middle = y[k] + rate[k] * (middle_time - t[k]);
      const float span = rate[k] * duration;
      weight.lane[l] += m;
      red.lane[l] += m * red_of[k];
      green.lane[l] += m * green_of[k];
      blue.lane[l] += m * blue_of[k];
      alpha.lane[l] += m * alpha_of[k];
      depth.lane[l] += m * (z[k] + z_rate[k] * (middle_time - t[k]));
      peaks.lane[l] += peak[k];
      // exp(−y²) differs from its mean over a span s about m by a factor of at most exp(±2s(|m| + s/2)).
      variation.lane[l] += m * (2.0f * span * (std::abs(middle) + 0.5f * span));
      widest.lane[l] = span > widest.lane[l] ? span : widest.lane[l];
    }
  MemberSum sum;
  sum.surface = {weight.total(), {red.total(), green.total(), blue.total(), alpha.total()}, depth.total()};
  sum.variation = variation.total();
  sum.peaks = peaks.total();
  sum.widest = widest.largest();
  return sum;
}

}  // namespace swept
