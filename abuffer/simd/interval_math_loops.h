// The text of interval_math.h's loops. Each translation unit that includes it builds them for its own
// instruction sets; nothing in it contracts and every sum has a fixed order, so all builds give the same
// bits.
#pragma once

#include <algorithm>
#include <bit>
#include <limits>

#include "abuffer/simd/interval_math.h"
#include "abuffer/simd/lanes.h"
#include "splat/kernel/kernel_integral.h"

namespace swept {
namespace {

/// exp(−y²) for |y| ≤ √87 within 2.3 ulp, without a branch, so that the loop around it becomes vectors.
///
/// y² rounded would cost half an ulp of its own, up to 32 of the result's. So y is cut after 12 bits: the
/// square of the first part is exact, and the rest of y² is small. Argument reduction by ln 2 in two parts
/// (Cody and Waite), exact but for the second part and the rest; the minimax polynomial of degree 6 on |r| ≤
/// ln(2)/2 with 1 + r in front is off by 2⁻²⁴ · 0.07.
SWEPT_INLINE Lanes exp_minus_square(const Lanes& y) {
  constexpr float round_to_integer = 0x1.8p23f;
  const Lanes first = floats_of(bits_of(y) & 0xfffff000u);
  const Lanes square = first * first, rest = (y - first) * (y + first);
  const Lanes shifted = round_to_integer - (square + rest) * 1.44269504f;
  const Lanes n = shifted - round_to_integer;
  const Lanes r = ((-square - n * 0x1.62e4p-1f) - n * 0x1.7f7d1cp-20f) - rest;
  Lanes p = all(0x1.6a2256p-10f);
  p = p * r + 0x1.123b02p-7f;
  p = p * r + 0x1.5558f8p-5f;
  p = p * r + 0x1.555490p-3f;
  p = p * r + 0x1.fffffcp-2f;
  p = p * r + 1.0f;
  p = p * r + 1.0f;
  return floats_of(bits_of(p) + (bits_of(shifted) << 23));
}

/// |y|, but no more than what exp_minus_square takes. A fragment's own y are within √50; but the times of one
/// that is faster than 10⁹ px are rounded by more than it takes to pass the pixel.
SWEPT_INLINE Lanes within_exp(const Lanes& y) { return smaller(magnitude(y), all(9.3f)); }

/// At most 1 where GaussianSeries<float>::factor keeps its error below 2⁻²⁴: for s ≤ ½ and |m| s ≤ 1 the
/// first term dropped is at most (m s)¹⁰/11! + s¹⁰/(4⁵·5!·11) ≤ 2.6e-8. `middle` ≥ 0.
SWEPT_INLINE Lanes series_reach(const Lanes& middle, const Lanes& span) {
  return larger(span * 2.0f, span * middle);
}

/// From members' t_begin to `time`, as a share of the exposure.
SWEPT_INLINE Lanes since(Ticks time, const float* t_begin) {
  return floats_from(static_cast<std::uint32_t>(time) - load_bits(t_begin)) * per_tick;
}

SWEPT_INLINE DepthRange depths_over_text(const Members& members, Ticks begin, Ticks end, float* z_begin,
                                         float* z_end) {
  const float *t = members.field(member_t_begin), *z = members.field(member_z),
              *z_rate = members.field(member_z_rate), *tolerance = members.field(member_tolerance),
              *speed = members.field(member_rate);
  const float duration = static_cast<float>(share_of(end - begin));
  constexpr float beyond = std::numeric_limits<float>::max();
  Lanes min_begin = all(beyond), min_end = min_begin, min_tolerance = min_begin;
  Lanes max_begin = all(-beyond), max_end = max_begin, max_tolerance = all(0.0f), max_rate = max_tolerance;
  for (std::size_t i = 0; i < members.padded; i += member_lanes) {
    const Lanes depth = load(z + i), rate = load(z_rate + i);
    const Lanes at_begin = depth + rate * since(begin, t + i), at_end = at_begin + rate * duration;
    const Lanes reach = load(tolerance + i);
    store(at_begin, z_begin + i);
    store(at_end, z_end + i);
    const LaneBits present = lanes_below(members.count - i);
    min_begin = smaller(min_begin, choose(present, at_begin, all(beyond)));
    max_begin = larger(max_begin, choose(present, at_begin, all(-beyond)));
    min_end = smaller(min_end, choose(present, at_end, all(beyond)));
    max_end = larger(max_end, choose(present, at_end, all(-beyond)));
    min_tolerance = smaller(min_tolerance, choose(present, reach, all(beyond)));
    max_tolerance = larger(max_tolerance, only(present, reach));
    max_rate = larger(max_rate, only(present, load(speed + i)));
  }
  return {smallest(min_begin),     largest(max_begin),     smallest(min_end), largest(max_end),
          smallest(min_tolerance), largest(max_tolerance), largest(max_rate)};
}

/// For the eight members from `first` on, where the series does not hold. Ends in double, which has the
/// digits that y² asks for.
[[gnu::noinline]] inline void long_means(const Members& members, std::size_t first, Ticks begin, Ticks end,
                                         const Lanes& reach, float* mean) {
  const float *t = members.field(member_t_begin), *y = members.field(member_y),
              *rate = members.field(member_rate), *peak = members.field(member_peak);
  for (std::size_t k = first; k < std::min(first + member_lanes, members.count); ++k) {
    if (reach[k - first] <= 1.0f) continue;
    const auto y_at = [&](Ticks time) {
      return y[k] + double{rate[k]} * share_of(time - std::bit_cast<Ticks>(t[k]));
    };
    mean[k] = peak[k] * mean_gaussian_as<float>(y_at(begin), y_at(end));
  }
}

SWEPT_INLINE MemberSum sum_over_text(const Members& members, Ticks begin, Ticks end, float* mean) {
  const float *t = members.field(member_t_begin), *y = members.field(member_y),
              *rate = members.field(member_rate), *peak = members.field(member_peak),
              *z = members.field(member_z), *z_rate = members.field(member_z_rate);
  const float duration = static_cast<float>(share_of(end - begin)), half = 0.5f * duration;
  const float *red_of = members.field(member_red), *green_of = members.field(member_green),
              *blue_of = members.field(member_blue), *alpha_of = members.field(member_alpha);
  Lanes weight = all(0.0f), red = weight, green = weight, blue = weight, alpha = weight, depth = weight,
        variation = weight, peaks = weight, widest = weight;
  for (std::size_t i = 0; i < members.padded; i += member_lanes) {
    const LaneBits present = lanes_below(members.count - i);
    const Lanes speed = only(present, load(rate + i)), span = speed * duration;
    const Lanes to_middle = since(begin, t + i) + half;
    const Lanes middle = load(y + i) + speed * to_middle, of_exp = within_exp(middle);
    const Lanes highest = only(present, load(peak + i));
    Lanes m = highest * exp_minus_square(of_exp) * GaussianSeries<float>::factor(of_exp, span);
    store(m, mean + i);
    const Lanes reach = series_reach(of_exp, span);
    if (largest(reach) > 1.0f) {
      long_means(members, i, begin, end, reach, mean);
      m = load(mean + i);
    }
    weight += m;
    red += m * load(red_of + i);
    green += m * load(green_of + i);
    blue += m * load(blue_of + i);
    alpha += m * load(alpha_of + i);
    depth += m * (load(z + i) + load(z_rate + i) * to_middle);
    peaks += highest;
    // With x = s|m| the mean is at most exp(−m²) sinh(x)/x, and the least value, at an end, exp(−m² − x −
    // s²/4): they differ by at most the mean times x + s²/4 + x²/6, for 1 − e⁻ᵃ x/sinh x ≤ a + x²/6.
    const Lanes x = span * magnitude(middle);
    variation += m * (x + 0.25f * (span * span) + (1.0f / 6.0f) * (x * x));
    widest = larger(widest, span);
  }
  MemberSum sum;
  static_assert(offsetof(MemberSum, peaks) == 7 * sizeof(float), "totals in the order of its members");
  const Lanes first_eight = totals(weight, red, green, blue, alpha, depth, variation, peaks);
  std::memcpy(static_cast<void*>(&sum), &first_eight, sizeof first_eight);
  sum.widest = largest(widest);
  return sum;
}

}  // namespace
}  // namespace swept

#undef SWEPT_INLINE
