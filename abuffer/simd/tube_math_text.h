// What tube_math.h declares, in terms of the Doubles and Mask that were included before. One text for every
// instruction set; each line is one of intersect_tube() or intersect_bent_tube(), in the same order of
// operations.
#pragma once

#include <limits>

#include "abuffer/simd/tube_math.h"

namespace swept {
namespace {

struct Rays {
  Doubles u, v, z, du, dv, dz;
};

/// What rays find of a kernel, where they meet it.
struct Found {
  Doubles begin, end, nearest_squared, rate, y_begin, z_begin;
  Mask met, plain;
};

SWEPT_LANE Mask is_zero(Doubles a) { return (a <= all(0.0)) & (all(0.0) <= a); }

/// Whether the speed is the root of `square` for length_of(), too, or nothing moves.
SWEPT_LANE Mask is_plain(Doubles square, Mask still) {
  constexpr double largest = std::numeric_limits<double>::max();
  constexpr double lowest = std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  return still | ((all(lowest) <= square) & (square <= all(largest)));
}

SWEPT_LANE Found find(const Rays& ray, const TubeSegment& segment) {
  constexpr double largest = std::numeric_limits<double>::max();
  const Doubles zero = all(0.0), one = all(1.0), segment_begin = all(segment.begin), near = all(segment.near);
  const Doubles t_mid = all(0.5 * (segment.begin + segment.end));
  const Doubles root_delta = all(__builtin_sqrt(segment.delta));
  const auto& [u, v, z, du, dv, dz] = ray;
  const Doubles square = du * du + dv * dv, speed = root(square);
  const Mask still = is_zero(du) & is_zero(dv);

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

  const Mask comes = dz < zero, level = is_zero(dz);
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
  return {begin, end, nearest_squared, rate, y_begin, z_begin, met, is_plain(square, still)};
}

/// A kernel on a parabola, along rays.
struct Bent {
  Rays mean;
  Doubles u, v, z;
  Doubles third;  ///< of the square of half the segment

  [[nodiscard]] SWEPT_LANE Rays line(Doubles at, Doubles spread) const {
    const Doubles moved = spread - third - at * at, twice = all(2.0) * at;
    return {mean.u + moved * u,  mean.v + moved * v,  mean.z + moved * z,
            mean.du + twice * u, mean.dv + twice * v, mean.dz + twice * z};
  }
};

struct FoundBent {
  Found found;
  Doubles z_rate;
};

SWEPT_LANE FoundBent find_bent(const Bent& path, const TubeSegment& segment) {
  const double half_time = 0.5 * (segment.end - segment.begin);
  const Doubles zero = all(0.0), one = all(1.0), three = all(3.0), one_half = all(0.5);
  const Doubles half = all(half_time), t_mid = all(0.5 * (segment.begin + segment.end));
  Rays tangent = path.mean;
  Doubles nearest = zero;
  for (int k = 0; k < 3; ++k) {
    const Doubles squared = tangent.du * tangent.du + tangent.dv * tangent.dv;
    const Doubles to = negative(tangent.u * tangent.du + tangent.v * tangent.dv) / squared;
    nearest = choose(negative(half) < to, choose(half < to, half, to),
                     choose(to <= negative(half), negative(half), zero));
    tangent = path.line(nearest, zero);
  }
  const Doubles square = tangent.du * tangent.du + tangent.dv * tangent.dv;
  const Mask plain = is_plain(square, is_zero(tangent.du) & is_zero(tangent.dv));
  const Doubles passing = one / root(square);
  Doubles begin = nearest - passing, end = nearest + passing;
  begin = choose(negative(half) < begin, begin, negative(half));
  end = choose(end < half, end, half);
  Doubles reach = one_half * (end - begin);
  const Found first = find(path.line(one_half * (begin + end), reach * reach / three), segment);
  begin = first.begin - t_mid;
  end = first.end - t_mid;
  reach = one_half * (end - begin);
  const Doubles before = negative(first.y_begin), after = first.y_begin + first.rate * (end - begin);
  const Doubles less = choose(after < before, after, before), both = choose(zero < less, less, zero);
  const Doubles a_squared = both * both;
  const Doubles mean_square = one / (three + a_squared * (all(0.8) + all(0.14) * a_squared));
  const Rays last = path.line(one_half * (begin + end), reach * reach * mean_square);
  Found found = find(last, segment);
  found.met = found.met & first.met;
  // Nothing that a first line misses is asked of the second.
  found.plain = plain & first.plain & (found.plain | without(is_zero(zero), first.met));
  return {found, last.dz};
}

SWEPT_LANE Rays rays_of(const TubeBlock& block, std::size_t i) {
  return {load(block.u + i),  load(block.v + i),  load(block.z + i),
          load(block.du + i), load(block.dv + i), load(block.dz + i)};
}

SWEPT_LANE void keep(const Found& found, TubeBlock& block, std::size_t i, TubeHits& hits) {
  store(found.begin, block.t_begin + i);
  store(found.end, block.t_end + i);
  store(found.nearest_squared, block.nearest_squared + i);
  store(found.rate, block.rate + i);
  store(found.y_begin, block.y_begin + i);
  store(found.z_begin, block.z_begin + i);
  const Mask yes = is_zero(all(0.0));
  hits.met |= std::uint64_t{bits(found.met & found.plain)} << i;
  hits.odd |= std::uint64_t{bits(without(yes, found.plain))} << i;
}

inline TubeHits first_of(TubeHits hits, std::size_t count) {
  const std::uint64_t looked_at = ~std::uint64_t{0} >> (TubeBlock::most - count);
  return {hits.met & looked_at, hits.odd & looked_at};
}

inline TubeHits intersect_text(TubeBlock& block, std::size_t count, const TubeSegment& segment) {
  TubeHits hits;
  for (std::size_t i = 0; i < count; i += double_lanes)
    keep(find(rays_of(block, i), segment), block, i, hits);
  return first_of(hits, count);
}

inline TubeHits intersect_bent_text(TubeBlock& block, const TubeBends& bends, std::size_t count,
                                    const TubeSegment& segment) {
  const double half = 0.5 * (segment.end - segment.begin);
  TubeHits hits;
  for (std::size_t i = 0; i < count; i += double_lanes) {
    const FoundBent bent = find_bent(
        {rays_of(block, i), load(bends.u + i), load(bends.v + i), load(bends.z + i), all(half * half / 3.0)},
        segment);
    store(bent.z_rate, block.dz + i);
    keep(bent.found, block, i, hits);
  }
  return first_of(hits, count);
}

}  // namespace
}  // namespace swept

#define SWEPT_DEFINE_TUBE_MATH(variable, text_name)                           \
  namespace swept {                                                           \
  extern const TubeMath variable;                                             \
  const TubeMath variable = {text_name, intersect_text, intersect_bent_text}; \
  }
