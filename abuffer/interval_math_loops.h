// The text of interval_math.h's loops. Each translation unit that includes it builds them for its own
// instruction sets; nothing in it contracts and every sum has a fixed order, so all builds give the same
// bits.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "abuffer/interval_math.h"
#include "splat/kernel_integral.h"

// A function built for one instruction set only inlines what it is told to.
#define SWEPT_INLINE [[gnu::always_inline]] inline

namespace swept {
namespace {

/// exp(−y²) for |y| ≤ √87 within 2.3 ulp, without a branch, so that the loop around it becomes vectors.
///
/// y² rounded would cost half an ulp of its own, up to 32 of the result's. So y is cut after 12 bits: the
/// square of the first part is exact, and the rest of y² is small. Argument reduction by ln 2 in two parts
/// (Cody and Waite), exact but for the second part and the rest; the minimax polynomial of degree 6 on |r| ≤
/// ln(2)/2 with 1 + r in front is off by 2⁻²⁴ · 0.07.
SWEPT_INLINE float exp_minus_square(float y) {
  constexpr float round_to_integer = 0x1.8p23f;
  const float first = std::bit_cast<float>(std::bit_cast<std::uint32_t>(y) & 0xfffff000u);
  const float square = first * first, rest = (y - first) * (y + first);
  const float shifted = round_to_integer - (square + rest) * 1.44269504f;
  const float n = shifted - round_to_integer;
  const float r = ((-square - n * 0x1.62e4p-1f) - n * 0x1.7f7d1cp-20f) - rest;
  float p = 0x1.6a2256p-10f;
  p = p * r + 0x1.123b02p-7f;
  p = p * r + 0x1.5558f8p-5f;
  p = p * r + 0x1.555490p-3f;
  p = p * r + 0x1.fffffcp-2f;
  p = p * r + 1.0f;
  p = p * r + 1.0f;
  const std::uint32_t exponent = std::bit_cast<std::uint32_t>(shifted) << 23;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(p) + exponent);
}

/// |y|, but no more than what exp_minus_square takes. A fragment's own y are within √50; but the times of one
/// that is faster than 10⁶ px are rounded by more than it takes to pass the pixel.
SWEPT_INLINE float within_exp(float y) {
  constexpr float farthest = 9.3f;
  const float distance = std::abs(y);
  return distance < farthest ? distance : farthest;
}

/// Where GaussianSeries<float>::factor keeps its error below 2⁻²⁴: the first term dropped is at most
/// (m s)¹⁰/11! + s¹⁰/(4⁵·5!·11) ≤ 2.6e-8.
SWEPT_INLINE bool series_holds(float middle, float span) {
  return span <= 0.5f && span * std::abs(middle) <= 1.0f;
}

/// One accumulator per lane, added up in a fixed order.
struct LaneSum {
  float lane[member_lanes] = {};

  [[nodiscard]] SWEPT_INLINE float total() const {
    static_assert(member_lanes == 8);
    return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
  }
  [[nodiscard]] SWEPT_INLINE float largest() const {
    float value = lane[0];
    for (float other : lane) value = other > value ? other : value;
    return value;
  }
};

SWEPT_INLINE DepthRange depths_over_text(const Members& members, float begin, float end, float* z_begin,
                                         float* z_end) {
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

SWEPT_INLINE MemberSum sum_over_text(const Members& members, float begin, float end, float* mean) {
  const float *t = members.field(member_t_begin), *y = members.field(member_y),
              *rate = members.field(member_rate), *peak = members.field(member_peak),
              *z = members.field(member_z), *z_rate = members.field(member_z_rate);
  const float duration = end - begin, middle_time = 0.5f * (begin + end);
  std::uint32_t long_spans = 0;
  for (std::size_t i = 0; i < members.padded; ++i) {
    const float middle = within_exp(y[i] + rate[i] * (middle_time - t[i]));
    const float span = rate[i] * duration;
    mean[i] = peak[i] * exp_minus_square(middle) * GaussianSeries<float>::factor(middle, span);
    long_spans += series_holds(middle, span) ? 0u : 1u;
  }
  if (long_spans > 0)
    for (std::size_t i = 0; i < members.count; ++i) {
      if (series_holds(within_exp(y[i] + rate[i] * (middle_time - t[i])), rate[i] * duration)) continue;
      // Ends in double, which has the digits that y² asks for.
      const auto y_at = [&](double time) { return y[i] + double{rate[i]} * (time - double{t[i]}); };
      mean[i] = peak[i] * mean_gaussian_as<float>(y_at(begin), y_at(end));
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

}  // namespace
}  // namespace swept

#undef SWEPT_INLINE
