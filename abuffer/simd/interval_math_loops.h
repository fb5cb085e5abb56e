// The text of interval_math.h's loops. Each translation unit that includes it builds them for its own
// instruction sets; nothing in it contracts and every sum has a fixed order, so all builds give the same
// bits.
#pragma once

#include <algorithm>
#include <bit>
#include <limits>

#include "abuffer/simd/front_bounds.h"
#include "abuffer/simd/interval_math.h"
#include "abuffer/simd/lanes.h"
#include "splat/interval/side.h"
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

/// Gauss's two points lie this much of a piece's half before and after its middle.
inline constexpr float root_third = 0.577350269f;

SWEPT_INLINE void swings_over_text(const Members& members, Ticks begin, Ticks end, const float* mean,
                                   const Swings& out) {
  const float *t = members.field(member_t_begin), *y = members.field(member_y),
              *rate = members.field(member_rate), *slope = members.field(member_z_rate);
  const auto duration = static_cast<float>(share_of(end - begin));
  for (std::size_t i = 0; i < members.padded; i += member_lanes) {
    const Lanes speed = load(rate + i), span = smaller(speed * duration, all(1e3f)), m = load(mean + i);
    const Lanes middle = load(y + i) + speed * (since(begin, t + i) + 0.5f * duration);
    const Lanes x = larger(smaller(middle, all(9.3f)), all(-9.3f)) * span, square = x * x + span * span;
    // The first terms of gaussian_centroid(), within what it can be.
    const Lanes series = x * ((1.0f / 90.0f) * square - (1.0f / 6.0f));
    const Lanes swing = m * (6.0f * root_third) * larger(smaller(series, all(0.25f)), all(-0.25f));
    store(swing, out.swing + i);
    // As the variation of sum_over_text().
    store(m * (magnitude(x) + 0.25f * (span * span) + (1.0f / 6.0f) * (x * x)), out.variation + i);
    const Lanes z_middle = 0.5f * (load(out.z_begin + i) + load(out.z_end + i));
    const Lanes z_swing = load(slope + i) * (0.5f * root_third * duration);
    store(m * z_middle + swing * z_swing, out.depth + i);
    store(swing * z_middle + m * z_swing, out.depth_swing + i);
  }
}

/// Of a piece, the times in which one member stays the nearest, and how deep the front reaches in each.
struct FrontTimes {
  static constexpr int most = 8;
  struct Span {
    Ticks begin, end;
    float limit_begin, limit_end;
  };
  Span span[most];
  int count = 0;
  Ticks settled_until = 0;  ///< where the spans end
};

SWEPT_INLINE void find_front_times(const Members& members, Ticks begin, Ticks end, FrontTimes& times) {
  const float *t = members.field(member_t_begin), *t_end = members.field(member_t_end),
              *z = members.field(member_z), *z_rate = members.field(member_z_rate),
              *tolerance = members.field(member_tolerance);
  constexpr float beyond = std::numeric_limits<float>::max();
  times.count = 0;
  Ticks now = begin;
  while (now < end && times.count < FrontTimes::most) {
    // The nearest of those that are there.
    Lanes least = all(beyond);
    LaneTicks least_at = all_ticks(0);
    const LaneTicks at_now = all_ticks(now);
    LaneTicks place = first_eight();
    for (std::size_t i = 0; i < members.padded; i += member_lanes, place = place + all_ticks(member_lanes)) {
      const LaneBits there = below(load_ticks(t + i), all_ticks(now + 1)) &
                             below(at_now, load_ticks(t_end + i)) & lanes_below(members.count - i);
      const Lanes depth = choose(there, load(z + i) + load(z_rate + i) * since(now, t + i), all(beyond));
      const LaneBits nearer = ~at_most(least, depth);
      least = choose(nearer, depth, least);
      least_at = choose(nearer, place, least_at);
    }
    float depth = beyond;
    std::int32_t nearest = std::numeric_limits<std::int32_t>::max();
    for (std::size_t i = 0; i < member_lanes; ++i)
      if (least[i] < depth || (least[i] == depth && least_at[i] < nearest)) {
        depth = least[i];
        nearest = least_at[i];
      }
    const bool found = depth < beyond;
    Ticks until = end;
    float slope = 0.0f;
    if (found) {
      until = std::min(until, std::bit_cast<Ticks>(t_end[nearest]));
      slope = z_rate[nearest];
    }

    // Until it ends, something nearer begins, or it is overtaken.
    LaneTicks sooner_begin = all_ticks(until);
    LaneBits overtaken = lanes_below(0);
    for (std::size_t i = 0; i < members.padded; i += member_lanes) {
      const LaneTicks born = load_ticks(t + i), from = later(born, at_now),
                      to = sooner(load_ticks(t_end + i), all_ticks(until));
      const LaneBits there = below(from, to) & lanes_below(members.count - i);
      const Lanes rate = load(z_rate + i);
      const Lanes behind = (load(z + i) + rate * (floats_from(from - born) * per_tick)) -
                           (depth + slope * (floats_from(from - at_now) * per_tick));
      const LaneBits comes = there & below(at_now, born) & ~at_most(all(0.0f), behind);
      sooner_begin = choose(comes, sooner(sooner_begin, born), sooner_begin);
      const Lanes behind_at_end = behind + (rate - slope) * (floats_from(to - from) * per_tick);
      overtaken = overtaken | (there & ~comes & ~at_most(all(0.0f), behind_at_end));
    }
    if (found && any(overtaken)) {
      for (std::size_t k = 0; k < members.count; ++k) {
        const Ticks born = std::bit_cast<Ticks>(t[k]), from = std::max(born, now);
        const Ticks to = std::min(std::bit_cast<Ticks>(t_end[k]), until);
        const float closing = slope - z_rate[k];
        if (!(from < to) || !(closing > 0.0f)) continue;
        const double behind = (z[k] + double{z_rate[k]} * share_of(from - born)) -
                              (depth + double{slope} * share_of(from - now));
        const double wait = std::max(behind, 0.0) / closing;
        if (wait < share_of(to - from))
          until = std::min(until, from + static_cast<Ticks>(wait * shutter_close) + 1);
      }
    }
    for (std::size_t i = 0; i < member_lanes; ++i) until = std::min<Ticks>(until, sooner_begin[i]);
    const float reach = found ? tolerance[nearest] : 0.0f, limit = found ? depth + reach : -beyond;
    times.span[times.count++] = {now, until, limit,
                                 found ? limit + slope * static_cast<float>(share_of(until - now)) : -beyond};
    now = until;
  }
  times.settled_until = now;
}

SWEPT_INLINE FrontSum front_over_text(const Members& members, Ticks begin, Ticks end) {
  const float *t = members.field(member_t_begin), *t_end = members.field(member_t_end),
              *y = members.field(member_y), *rate = members.field(member_rate),
              *peak = members.field(member_peak), *z = members.field(member_z),
              *z_rate = members.field(member_z_rate), *tolerance = members.field(member_tolerance),
              *jump = members.field(member_jump), *side = members.field(member_side);
  const float *red_of = members.field(member_red), *green_of = members.field(member_green),
              *blue_of = members.field(member_blue), *alpha_of = members.field(member_alpha);
  const auto duration = static_cast<float>(share_of(end - begin));
  constexpr float beyond = std::numeric_limits<float>::max();
  const LaneTicks first = all_ticks(begin), last = all_ticks(end);

  // The lower envelope at both ends, as if all were there all the time.
  Lanes min_begin = all(beyond), min_end = min_begin, max_begin = all(-beyond), max_end = max_begin,
        min_tolerance = min_begin, max_tolerance = all(0.0f);
  for (std::size_t i = 0; i < members.padded; i += member_lanes) {
    const LaneBits present = below(later(load_ticks(t + i), first), sooner(load_ticks(t_end + i), last)) &
                             lanes_below(members.count - i);
    const Lanes slope = load(z_rate + i);
    const Lanes at_begin = load(z + i) + slope * since(begin, t + i), at_end = at_begin + slope * duration;
    min_begin = smaller(min_begin, choose(present, at_begin, all(beyond)));
    min_end = smaller(min_end, choose(present, at_end, all(beyond)));
    max_begin = larger(max_begin, choose(present, at_begin, all(-beyond)));
    max_end = larger(max_end, choose(present, at_end, all(-beyond)));
    const Lanes reach = load(tolerance + i);
    min_tolerance = smaller(min_tolerance, choose(present, reach, all(beyond)));
    max_tolerance = larger(max_tolerance, only(present, reach));
  }
  FrontSum sum;
  sum.margin = 2.0f * largest(max_tolerance);
  FrontTimes times;
  times.count = 1;
  times.settled_until = end;
  const float nearest_begin = smallest(min_begin), nearest_end = smallest(min_end);
  const float within = smallest(min_tolerance);
  float thickness = sum.margin;
  if (largest(max_begin) - nearest_begin <= within && largest(max_end) - nearest_end <= within) {
    times.span[0] = {begin, end, beyond, beyond};
    sum.limit = std::max(largest(max_begin), largest(max_end)) + largest(max_tolerance);
    thickness = std::max(largest(max_begin) - nearest_begin, largest(max_end) - nearest_end);
  } else {
    find_front_times(members, begin, end, times);
    sum.limit = -beyond;
    for (int k = 0; k < times.count; ++k)
      sum.limit = std::max({sum.limit, times.span[k].limit_begin, times.span[k].limit_end});
  }
  sum.settled_until = times.settled_until;
  sum.changes_at = times.count > 1 ? times.span[1].begin : end;
  if (times.settled_until < end) return sum;

  Lanes weight = all(0.0f), red = weight, green = weight, blue = weight, alpha = weight, depth = weight,
        low = weight, jumps = weight, weight_swing = weight, red_swing = weight, green_swing = weight,
        blue_swing = weight, alpha_swing = weight, depth_swing = weight, peaks = weight, low_slope = weight,
        fastest = weight, reaches = weight;
  LaneBits behind = lanes_below(0), unsettled = behind, sides = behind;
  FrontPresence presence;
  const bool noted = members.padded <= FrontPresence::most * member_lanes;
  const float per_duration = 1.0f / static_cast<float>(end - begin);
  for (std::size_t i = 0; i < members.padded; i += member_lanes) {
    const LaneTicks born = load_ticks(t + i), dies = load_ticks(t_end + i);
    const Lanes slope = load(z_rate + i);
    const Lanes at_begin = load(z + i) + slope * since(begin, t + i), at_end = at_begin + slope * duration;
    const LaneBits lanes = lanes_below(members.count - i);
    LaneTicks from = last, to = first, in_all = all_ticks(0);
    for (int k = 0; k < times.count; ++k) {
      const FrontTimes::Span& part = times.span[k];
      const LaneTicks begins = later(born, all_ticks(part.begin)), ends = sooner(dies, all_ticks(part.end));
      const LaneBits there = below(begins, ends) & lanes;
      LaneBits in_front = there;
      if (part.limit_begin < beyond) {
        const Lanes at = load(z + i);
        const LaneBits in_at_begin = at_most(at + slope * since(part.begin, t + i), all(part.limit_begin));
        const LaneBits in_at_end = at_most(at + slope * since(part.end, t + i), all(part.limit_end));
        unsettled = unsettled | (there & ((in_at_begin & ~in_at_end) | (in_at_end & ~in_at_begin)));
        in_front = there & in_at_begin & in_at_end;
        behind = behind | (there & ~in_front);
      }
      from = choose(in_front, sooner(from, begins), from);
      to = choose(in_front, later(to, ends), to);
      in_all = in_all + choose(in_front, ends - begins, all_ticks(0));
    }
    if (noted) {
      presence.from[i / member_lanes] = from;
      presence.to[i / member_lanes] = to;
    }
    const LaneBits in_front = below(from, to);
    sides = sides | (in_front & load_bits(side + i));
    // One that leaves the front and comes back.
    unsettled = unsettled | (in_front & below(in_all, to - from));
    const LaneBits partial = below(first, from) | below(to, last);
    const LaneBits cut_off = (below(born, from) & below(first, from)) | (below(to, dies) & below(to, last));

    // ρ about the middle of the time that the member is there.
    const Lanes ticks = only(in_front, floats_from(to - from));
    const Lanes there = ticks * per_tick;
    const Lanes speed = only(in_front, load(rate + i)), span = speed * there;
    const Lanes middle = load(y + i) + speed * (floats_from(from - born) * per_tick + 0.5f * there);
    const Lanes of_exp = within_exp(middle);
    const Lanes highest = only(in_front, load(peak + i));
    const Lanes at_middle = highest * exp_minus_square(of_exp);
    const Lanes m = at_middle * GaussianSeries<float>::factor(of_exp, span);
    // Where the first term dropped of the series is below 10⁻⁶: (m s)¹⁰/11! + s¹⁰/(4⁵·5!·11).
    reaches = larger(reaches, larger(span * 1.25f, span * of_exp * (1.0f / 1.4f)));
    fastest = larger(fastest, speed);

    // Of the piece the member's share, and how far after the piece's middle its own is.
    const Lanes share = choose(partial, ticks * per_duration, only(in_front, all(1.0f)));
    const Lanes after = (floats_from(from - first) - floats_from(last - to)) * (0.5f * per_duration);
    const Lanes x = larger(smaller(middle, all(9.3f)), all(-9.3f)) * span;
    const Lanes centroid = centroid_of(x, span);
    const Lanes mean = share * m;
    const Lanes swing = mean * (after + share * centroid) * (6.0f * root_third);

    const Lanes z_middle = 0.5f * (at_begin + at_end), z_swing = slope * (0.5f * root_third * duration);
    weight += mean;
    weight_swing += swing;
    const Lanes r = load(red_of + i), g = load(green_of + i), b = load(blue_of + i), a = load(alpha_of + i);
    red += mean * r;
    green += mean * g;
    blue += mean * b;
    alpha += mean * a;
    red_swing += swing * r;
    green_swing += swing * g;
    blue_swing += swing * b;
    alpha_swing += swing * a;
    depth += mean * z_middle + swing * z_swing;
    depth_swing += swing * z_middle + mean * z_swing;
    peaks += highest;
    // exp(−(m + st)²) ≥ exp(−m²) (1 − 2mst − s²t²), |t| ≤ ½: least where the sum of the slopes says.
    const Lanes all_along = only(~partial, at_middle);
    low += all_along * (1.0f - 0.25f * (span * span));
    low_slope += all_along * x;
    const Lanes step = only(
        partial & in_front,
        choose(cut_off, m * (1.0f + magnitude(x) * (1.0f + (1.0f / 3.0f) * magnitude(x))), load(jump + i)));
    jumps += step;
  }
  static_assert(offsetof(FrontSum, jumps) == 7 * sizeof(float) &&
                    offsetof(FrontSum, swing) == 8 * sizeof(float) &&
                    offsetof(FrontSum, peaks) == 14 * sizeof(float),
                "totals in the order of its members");
  const Lanes means = totals(weight, red, green, blue, alpha, depth, low, jumps);
  const Lanes swings =
      totals(weight_swing, red_swing, green_swing, blue_swing, alpha_swing, depth_swing, peaks, fastest);
  std::memcpy(static_cast<void*>(&sum), &means, sizeof means);
  std::memcpy(static_cast<void*>(&sum.swing), &swings, 7 * sizeof(float));
  sum.low = std::max(0.0f, sum.low - std::abs(total(low_slope)));
  sum.fastest = largest(fastest);
  sum.behind = any(behind);
  std::uint32_t all_sides = 0;
  for (std::size_t i = 0; i < member_lanes; ++i) all_sides |= sides[i];
  sum.mixed = both_sides(all_sides);
  // Where, is not known; until the front's nearest changes first, nothing comes back.
  if (any(unsettled)) sum.settled_until = times.count > 1 ? times.span[1].begin : begin;
  if (sum.settled_until < end) return sum;
  if (noted) {
    sum.range = std::max(color_range(members, presence),
                         thickness * sum.mean.weight / std::max(sum.mean.depth, 1e-30f));
    if (sum.low < members.enough) sum.low = std::max(sum.low, least_weight(members, begin, end, presence));
  }
  if (!(largest(reaches) <= like_members_of(sum.range).reach)) sum.settled_until = begin;
  return sum;
}

SWEPT_INLINE PresenceRange presences_over_text(const Members& members, Ticks begin, Ticks end,
                                               const Presences& out) {
  const float *t = members.field(member_t_begin), *t_end = members.field(member_t_end),
              *y = members.field(member_y), *rate = members.field(member_rate),
              *peak = members.field(member_peak), *z = members.field(member_z),
              *z_rate = members.field(member_z_rate), *tolerance = members.field(member_tolerance),
              *jump = members.field(member_jump);
  const auto duration = static_cast<float>(share_of(end - begin));
  const float per_duration = 1.0f / static_cast<float>(end - begin);
  const LaneTicks first = all_ticks(begin), last = all_ticks(end);
  Lanes max_rate = all(0.0f), max_tolerance = max_rate, reaches = max_rate;
  for (std::size_t i = 0; i < members.padded; i += member_lanes) {
    const LaneBits present = lanes_below(members.count - i);
    const LaneTicks born = load_ticks(t + i), dies = load_ticks(t_end + i);
    const LaneTicks from = later(born, first), to = sooner(dies, last);
    const LaneBits begins = below(first, from), ends = below(to, last), partial = begins | ends;
    // ρ about the middle of the time that the member is there, as in front_over_text().
    const Lanes ticks = floats_from(to - from), there = ticks * per_tick;
    const Lanes speed = only(present, load(rate + i)), span = speed * there;
    const Lanes until_there = floats_from(from - born) * per_tick;
    const Lanes middle = load(y + i) + speed * (until_there + 0.5f * there);
    const Lanes of_exp = within_exp(middle);
    const Lanes at_middle = only(present, load(peak + i)) * exp_minus_square(of_exp);
    const Lanes m = at_middle * GaussianSeries<float>::factor(of_exp, span);
    reaches = larger(reaches, only(present, series_reach(of_exp, span)));
    max_rate = larger(max_rate, speed);
    max_tolerance = larger(max_tolerance, only(present, load(tolerance + i)));

    const Lanes share = choose(partial, ticks * per_duration, all(1.0f));
    const Lanes after = (floats_from(from - first) - floats_from(last - to)) * (0.5f * per_duration);
    const Lanes x = larger(smaller(middle, all(9.3f)), all(-9.3f)) * span, square = x * x + span * span;
    const Lanes centroid = x * ((1.0f / 90.0f) * square - (1.0f / 6.0f));
    const Lanes mean = share * m, swing = mean * (after + share * centroid) * (6.0f * root_third);
    store(mean, out.mean + i);
    store(swing, out.swing + i);
    // While it is there, as the variation of sum_over_text(); one that is not there always may be anything
    // from 0 to its most.
    const Lanes within = m * (magnitude(x) + 0.25f * (span * span) + (1.0f / 6.0f) * (x * x));
    store(choose(partial, m + within + within, within), out.variation + i);
    const Lanes step = load(jump + i);
    store(only(begins, step) + only(ends, step), out.jump + i);

    const Lanes slope = load(z_rate + i), z_from = load(z + i) + slope * until_there;
    store(z_from, out.z_from + i);
    store(z_from + slope * there, out.z_to + i);
    // On the line through its depths, prolonged to all of the piece.
    const Lanes z_middle = z_from + slope * (0.5f * duration - floats_from(from - first) * per_tick);
    const Lanes z_swing = slope * (0.5f * root_third * duration);
    store(mean * z_middle + swing * z_swing, out.depth + i);
    store(swing * z_middle + mean * z_swing, out.depth_swing + i);
  }
  return {largest(max_rate), largest(max_tolerance), largest(reaches)};
}

}  // namespace
}  // namespace swept

#undef SWEPT_INLINE
