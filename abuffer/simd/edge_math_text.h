// What edge_math.h declares, in terms of the Doubles and Mask that were included before. One text for every
// instruction set, and the arithmetic of quadratic_sign_changes() operation by operation.
#pragma once

#include <limits>

#include "abuffer/simd/chord_math_text.h"
#include "abuffer/simd/edge_math.h"

namespace swept {
namespace {

/// Where one edge function changes its sign: at `one`, and back at `two`; 1 if it does not.
struct Changes {
  Doubles one, two;
  Mask twice;
};

SWEPT_LANE Changes changes_of(const Doubles (&c)[3]) {
  const Doubles zero = all(0.0), unit = all(1.0), endless = all(std::numeric_limits<double>::infinity());
  const Doubles product = c[0] * c[2];
  const Doubles discriminant = fused(c[1], c[1], negative(product)) + fused(negative(c[0]), c[2], product);
  const Mask real = zero < discriminant;
  const Doubles square_root = root(choose(real, discriminant, unit));
  const Doubles q = choose(zero < c[1], negative(c[1] + square_root), square_root - c[1]);
  const Doubles r[2] = {q / c[2], c[0] / q};
  const Doubles low = smaller(r[0], r[1]), high = larger(r[0], r[1]);
  const auto share = [&](Doubles x) {
    const Mask near = x <= unit;
    return choose(near, x, unit) / (unit + choose(near, x, unit / x));
  };
  const Mask has_low = real & (zero < low) & (low < endless),
             has_high = real & (zero < high) & (high < endless);
  const Doubles at_low = choose(has_low, share(low), unit), at_high = choose(has_high, share(high), unit);
  return {choose(has_low, at_low, at_high), choose(has_low, at_high, unit), has_low & has_high};
}

inline void meet_text(const StraightEdges& edges, const double* x, const double* y, MetPlaces& met) {
  const Doubles zero = all(0.0), unit = all(1.0);
  const Mask yes = zero <= zero, no = zero < zero;
  met.above = met.below = met.unknown = 0;
  for (int part = 0; part < pixel_places; part += double_lanes) {
    const Doubles ray_x = load(x + part), ray_y = load(y + part);
    Doubles c[3][3];
    Mask up[3], down[3];
    for (int i = 0; i < 3; ++i) {
      up[i] = down[i] = yes;
      for (int k = 0; k < 3; ++k) {
        const double* const normal = edges.edge[i] + 3 * k;
        c[i][k] = all(normal[0]) * ray_x + (all(normal[1]) * ray_y + all(normal[2]));
        up[i] = up[i] & (zero < c[i][k]);
        down[i] = down[i] & (c[i][k] < zero);
      }
    }
    const Mask may_above = edges.shows_above ? without(yes, down[0] | down[1] | down[2]) : no,
               may_below = edges.shows_below ? without(yes, up[0] | up[1] | up[2]) : no;
    const Mask may = may_above | may_below;
    if (bits(may) == 0) continue;
    Mask unknown = no, split_above = no, split_below = no;
    Doubles first_above = zero, last_above = unit, first_below = zero, last_below = unit;
    for (int i = 0; i < 3; ++i) {
      const Doubles(&e)[3] = c[i];
      const Doubles size[3] = {magnitude(e[0]), magnitude(e[1]), magnitude(e[2])};
      const Mask in_range = (size[0] < all(1e100)) & (size[1] < all(1e100)) & (size[2] < all(1e100)) &
                            ((all(1e-100) < size[0]) | (all(1e-100) < size[1]) | (all(1e-100) < size[2]));
      unknown = unknown | without(may, in_range);
      // 0 at an end alone does not count as a sign, and three of one sign have no root.
      const Mask not_below = (zero <= e[0]) & (zero <= e[1]) & (zero <= e[2]),
                 not_above = (e[0] <= zero) & (e[1] <= zero) & (e[2] <= zero);
      const auto by = [&](int k, Mask otherwise) { return (zero < e[k]) | without(otherwise, e[k] < zero); };
      const Mask begins_above = by(0, by(1, zero < e[2]));
      Changes changes{unit, unit, no};
      const Mask rooted = without(may, not_below | not_above);
      if (bits(rooted) != 0) {
        changes = changes_of(e);
        changes.one = choose(rooted, changes.one, unit);
        changes.two = choose(rooted, changes.two, unit);
        changes.twice = rooted & changes.twice;
      }
      // To the first change on the side where it begins, then on the other one, to the second.
      first_above = larger(first_above, choose(begins_above, zero, changes.one));
      first_below = larger(first_below, choose(begins_above, changes.one, zero));
      const Doubles first_end = choose(changes.twice, unit, changes.one);
      last_above = smaller(last_above, choose(begins_above, first_end, changes.two));
      last_below = smaller(last_below, choose(begins_above, changes.two, first_end));
      split_above = split_above | (changes.twice & begins_above);
      split_below = split_below | without(changes.twice, begins_above);
    }
    const Mask above = may_above & (first_above < last_above), below = may_below & (first_below < last_below);
    unknown = unknown | (split_above & above) | (split_below & below);
    store(first_above, met.first[0] + part);
    store(last_above, met.last[0] + part);
    store(first_below, met.first[1] + part);
    store(last_below, met.last[1] + part);
    met.above |= bits(without(above, unknown)) << part;
    met.below |= bits(without(below, unknown)) << part;
    met.unknown |= bits(unknown) << part;
  }
}

}  // namespace
}  // namespace swept

#define SWEPT_DEFINE_EDGE_MATH(variable, text_name)              \
  namespace swept {                                              \
  extern const EdgeMath variable;                                \
  const EdgeMath variable = {text_name, meet_text, chords_text}; \
  }
