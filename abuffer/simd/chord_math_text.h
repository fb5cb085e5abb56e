// EdgeMath::chords, in terms of the Doubles and Mask that were included before. One text for every
// instruction set; operation by operation what place_peel.cpp has for paths of any degree.
#pragma once

#include <limits>

#include "abuffer/simd/edge_math.h"

namespace swept {
namespace {

/// Of these Bernstein coefficients, those of the part from `from` to `to`.
template <int size>
SWEPT_LANE void take_part(Doubles (&c)[size], Doubles from, Doubles to, Doubles share) {
  for (int level = 1; level < size; ++level)
    for (int k = 0; k + level < size; ++k) c[k] = c[k] + from * (c[k + 1] - c[k]);
  const Mask ends = to < all(1.0);
  for (int level = 1; level < size; ++level)
    for (int k = size - 1; k >= level; --k) c[k] = choose(ends, c[k - 1] + share * (c[k] - c[k - 1]), c[k]);
}

inline void chords_text(DepthChords& of) {
  const Doubles zero = all(0.0), unit = all(1.0), endless = all(std::numeric_limits<double>::infinity());
  for (int lane = 0; lane < DepthChords::most; lane += double_lanes) {
    const auto in = [&](const double* from) { return load(from + lane); };
    const auto out = [&](Doubles v, double* to) { store(v, to + lane); };
    const Doubles since = in(of.since), lasts = in(of.until) - since, begin = in(of.begin), end = in(of.end);
    const auto local = [&](Doubles time) { return smaller(larger((time - since) / lasts, zero), unit); };
    const Doubles from = local(begin), to = larger(local(end), from);
    const Mask late = unit <= from;
    const Doubles share = choose(late, zero, (to - from) / choose(late, unit, unit - from));
    Doubles over[4], under[3];
    for (int k = 0; k < 4; ++k) over[k] = in(of.above[k]);
    for (int k = 0; k < 3; ++k) under[k] = in(of.below[k]);
    take_part(over, from, to, share);
    take_part(under, from, to, share);
    const Doubles three = all(3.0), two = all(2.0);
    Doubles z[3] = {over[0] / under[0],
                    ((over[0] + three * over[1] + three * over[2] + over[3]) * all(0.125)) /
                        ((under[0] + two * under[1] + under[2]) * all(0.25)),
                    over[3] / under[2]};
    // above − line·below is 0 at the ends: u (1 − u) times a line, which is no larger than its coefficients.
    const Doubles third = all(1.0 / 3.0), two_thirds = all(2.0 / 3.0);
    const Doubles apart[2] = {two_thirds * (z[0] * under[1]) + third * (z[2] * under[0]),
                              third * (z[0] * under[2]) + two_thirds * (z[2] * under[1])};
    Doubles most = zero, largest = zero, least_under = magnitude(under[0]);
    for (int k = 0; k < 4; ++k) largest = larger(magnitude(over[k]), largest);
    for (int k = 1; k < 3; ++k) least_under = smaller(magnitude(under[k]), least_under);
    for (int k = 1; k < 3; ++k) most = larger(three * magnitude(over[k] - apart[k - 1]), most);
    const Mask one_sided = ((zero < under[0]) & (zero < under[1]) & (zero < under[2])) |
                           ((under[0] < zero) & (under[1] < zero) & (under[2] < zero));
    Doubles bow = (most + all(1e-13) * largest) / least_under;
    bow = choose(one_sided & (bow < endless), bow, endless);
    // Never outside of these depths, where rounding may put a quotient of what is nearly 0.
    const Doubles nearest = in(of.nearest), farthest = in(of.farthest);
    for (Doubles& depth : z) {
      const Doubles within = smaller(larger(depth, nearest), farthest);
      bow = choose((depth <= within) & (within <= depth), bow, endless);
      depth = within;
    }
    out(z[0], of.z_begin);
    out(z[1], of.z_middle);
    out(z[2], of.z_end);
    out(bow, of.bow);
    out(unit / (end - begin), of.per_time);
  }
}

}  // namespace
}  // namespace swept
