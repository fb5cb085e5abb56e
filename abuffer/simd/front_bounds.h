// A closer look at a front whose first bounds do not do. Included by interval_math_loops.h; every sum has a
// fixed order, so all builds give the same bits.
#pragma once

#include <algorithm>
#include <bit>
#include <limits>

#include "abuffer/simd/interval_math.h"
#include "abuffer/simd/lanes.h"

namespace swept {
namespace {

/// When each member is part of the front: from ≥ to where it never is.
struct FrontPresence {
  static constexpr std::size_t most = 32;  ///< vectors; of larger fronts the first bounds have to do
  LaneTicks from[most], to[most];
};

/// At most exp(−s) for s ≥ 0, as (1 − s/16)¹⁶ is, and nearly that for s ≤ 3.
SWEPT_INLINE Lanes below_exp(const Lanes& s) {
  const Lanes u = larger(1.0f - s * (1.0f / 16.0f), all(0.0f));
  const Lanes u2 = u * u, u4 = u2 * u2, u8 = u4 * u4;
  return u8 * u8;
}

/// Σρ of the front is nowhere less. A member's ρ rises and then falls, so within a part of the piece in which
/// it is there all the time it is least at one end of the part.
SWEPT_INLINE float least_weight(const Members& members, Ticks begin, Ticks end,
                                const FrontPresence& presence) {
  constexpr int parts = 4;
  const float *t = members.field(member_t_begin), *y = members.field(member_y),
              *rate = members.field(member_rate), *peak = members.field(member_peak);
  Ticks times[parts + 1];
  for (int p = 0; p <= parts; ++p)
    times[p] = begin + static_cast<Ticks>(static_cast<std::int64_t>(end - begin) * p / parts);
  Lanes sums[parts];
  for (Lanes& sum : sums) sum = all(0.0f);
  for (std::size_t i = 0; i < members.padded; i += member_lanes) {
    const LaneTicks from = presence.from[i / member_lanes], to = presence.to[i / member_lanes],
                    born = load_ticks(t + i);
    const Lanes speed = load(rate + i), at_birth = load(y + i);
    const LaneBits present = below(from, to);
    const Lanes highest = only(present, load(peak + i));
    const auto weight_at = [&](Ticks time) {
      // One that is not yet there is as it will be when it begins; it does not count then.
      const Lanes since_birth = floats_from(later(all_ticks(time) - born, all_ticks(0))) * per_tick;
      const Lanes at = smaller(magnitude(at_birth + speed * since_birth), all(1e3f));
      return highest * below_exp(at * at);
    };
    Lanes before = weight_at(times[0]);
    for (int p = 0; p < parts; ++p) {
      const Lanes after = weight_at(times[p + 1]);
      const LaneBits misses = below(all_ticks(times[p]), from) | below(to, all_ticks(times[p + 1]));
      sums[p] += only(~misses, smaller(before, after));
      before = after;
    }
  }
  float least = total(sums[0]);
  for (int p = 1; p < parts; ++p) least = std::min(least, total(sums[p]));
  // The rounding of 16 factors and of the sum.
  return least * (1.0f - 0x1p-17f);
}

/// How far after its middle the centroid of exp(−(m + s t)²), |t| ≤ ½, is, with x = ms: that of exp(−2xt) is
/// −½ (coth x − 1/x), here as a quotient that is off by less than 0.03 for |x| ≤ 3, and what s² adds in its
/// first term.
SWEPT_INLINE Lanes centroid_of(const Lanes& x, const Lanes& s) {
  const Lanes square = x * x;
  return x * ((1.0f / 90.0f) * (s * s) - (7.5f + 0.5f * square) / (45.0f + 6.0f * square));
}

/// The widest range of any channel among the front's members.
SWEPT_INLINE float color_range(const Members& members, const FrontPresence& presence) {
  constexpr float beyond = std::numeric_limits<float>::max();
  float range = 0.0f;
  for (const MemberField channel : {member_red, member_green, member_blue, member_alpha}) {
    const float* const of = members.field(channel);
    Lanes low = all(beyond), high = all(-beyond);
    for (std::size_t i = 0; i < members.padded; i += member_lanes) {
      const LaneBits present = below(presence.from[i / member_lanes], presence.to[i / member_lanes]);
      const Lanes value = load(of + i);
      low = smaller(low, choose(present, value, all(beyond)));
      high = larger(high, choose(present, value, all(-beyond)));
    }
    range = std::max(range, largest(high) - smallest(low));
  }
  return range;
}

}  // namespace
}  // namespace swept
