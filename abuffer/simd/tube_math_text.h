// What tube_math.h declares, in terms of the Doubles and Mask that were included before. One text for every
// instruction set; each line is one of intersect_tube(), in the same order of operations.
#pragma once

#include <limits>

#include "abuffer/simd/tube_math.h"

namespace swept {
namespace {

inline TubeHits intersect_text(TubeBlock& block, std::size_t count, const TubeSegment& segment) {
  constexpr double largest = std::numeric_limits<double>::max();
  // As length_of() has it.
  constexpr double lowest = std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  const Doubles zero = all(0.0), one = all(1.0), segment_begin = all(segment.begin), near = all(segment.near);
  const Mask yes = zero <= zero;
  const Doubles t_mid = all(0.5 * (segment.begin + segment.end));
  const Doubles root_delta = all(__builtin_sqrt(segment.delta));
  TubeHits hits;
  for (std::size_t i = 0; i < count; i += double_lanes) {
    const Doubles u = load(block.u + i), v = load(block.v + i), z = load(block.z + i);
    const Doubles du = load(block.du + i), dv = load(block.dv + i), dz = load(block.dz + i);
    const Doubles square = du * du + dv * dv, speed = root(square);
    const Mask still = (du <= zero) & (zero <= du) & (dv <= zero) & (zero <= dv);
    const Mask plain = still | ((all(lowest) <= square) & (square <= all(largest)));

    const Doubles divisor = choose(still, one, speed);
    const Doubles direction_u = du / divisor, direction_v = dv / divisor;
    const Doubles across = u * direction_v - v * direction_u;
    const Doubles along = u * direction_u + v * direction_v;
    const Doubles nearest_squared = choose(still, u * u + v * v, across * across);
    Mask met = nearest_squared <= one;
    const Doubles half_chord = root((one - across) * (one + across));
    const Doubles entry = t_mid + (negative(half_chord) - along) / divisor;
    const Doubles exit = t_mid + (half_chord - along) / divisor;
    const Mask late = without(segment_begin < entry, still), soon = without(exit < all(segment.end), still);
    Doubles begin = choose(late, entry, segment_begin);
    Doubles end = choose(soon, exit, all(segment.end));
    Doubles position = choose(late, negative(half_chord), along + speed * (begin - t_mid));
    position = choose(still, zero, position);

    const Mask comes = dz < zero, level = (dz <= zero) & (zero <= dz);
    const Doubles crossing = t_mid + (near - z) / choose(level, one, dz);
    end = choose(comes & (crossing < end), crossing, end);
    const Mask appears = without(begin < crossing, comes | level);
    position = choose(appears, position + speed * (crossing - begin), position);
    begin = choose(appears, crossing, begin);
    met = without(met, without(level, near <= z)) & (begin < end);

    const Doubles rate = root_delta * speed, y_begin = root_delta * position;
    const Doubles z_begin = z + dz * (begin - t_mid);
    met = met & (magnitude(z_begin) <= all(largest)) & (magnitude(dz) <= all(largest)) &
          (magnitude(y_begin) <= all(largest)) & (rate <= all(largest));
    store(begin, block.t_begin + i);
    store(end, block.t_end + i);
    store(nearest_squared, block.nearest_squared + i);
    store(rate, block.rate + i);
    store(y_begin, block.y_begin + i);
    store(z_begin, block.z_begin + i);
    hits.met |= std::uint64_t{bits(met & plain)} << i;
    hits.odd |= std::uint64_t{bits(without(yes, plain))} << i;
  }
  const std::uint64_t looked_at = ~std::uint64_t{0} >> (TubeBlock::most - count);
  hits.met &= looked_at;
  hits.odd &= looked_at;
  return hits;
}

}  // namespace
}  // namespace swept

#define SWEPT_DEFINE_TUBE_MATH(variable, text_name)      \
  namespace swept {                                      \
  extern const TubeMath variable;                        \
  const TubeMath variable = {text_name, intersect_text}; \
  }
