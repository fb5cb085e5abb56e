// What tube_math.h declares, in vectors of SWEPT_TUBE_LANES doubles. One text for every instruction set; each
// line is one of intersect_tube(), in the same order of operations.
#pragma once

#include <cstring>
#include <limits>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "abuffer/simd/tube_math.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace swept {
namespace {

#define SWEPT_TUBE [[gnu::always_inline]] inline

using Doubles = double __attribute__((vector_size(8 * SWEPT_TUBE_LANES)));
using DoubleMask = std::int64_t __attribute__((vector_size(8 * SWEPT_TUBE_LANES)));

SWEPT_TUBE Doubles all(double x) { return x - Doubles{}; }
SWEPT_TUBE Doubles load(const double* from) {
  Doubles x;
  std::memcpy(&x, from, sizeof x);
  return x;
}
SWEPT_TUBE void store(const Doubles& x, double* to) { std::memcpy(to, &x, sizeof x); }
SWEPT_TUBE Doubles choose(const DoubleMask& mask, const Doubles& a, const Doubles& b) { return mask ? a : b; }
SWEPT_TUBE Doubles magnitude(const Doubles& x) {
  return (Doubles)((DoubleMask)x & std::numeric_limits<std::int64_t>::max());
}

#if SWEPT_TUBE_LANES == 8
SWEPT_TUBE Doubles root(const Doubles& x) { return (Doubles)_mm512_sqrt_pd((__m512d)x); }
SWEPT_TUBE std::uint64_t bits(const DoubleMask& m) { return _mm512_movepi64_mask((__m512i)m); }
#elif SWEPT_TUBE_LANES == 4
SWEPT_TUBE Doubles root(const Doubles& x) { return (Doubles)_mm256_sqrt_pd((__m256d)x); }
SWEPT_TUBE std::uint64_t bits(const DoubleMask& m) {
  return static_cast<std::uint64_t>(_mm256_movemask_pd((__m256d)m));
}
#elif SWEPT_TUBE_LANES == 2
SWEPT_TUBE Doubles root(const Doubles& x) { return (Doubles)_mm_sqrt_pd((__m128d)x); }
SWEPT_TUBE std::uint64_t bits(const DoubleMask& m) {
  return static_cast<std::uint64_t>(_mm_movemask_pd((__m128d)m));
}
#else
SWEPT_TUBE Doubles root(const Doubles& x) { return Doubles{__builtin_sqrt(x[0])}; }
SWEPT_TUBE std::uint64_t bits(const DoubleMask& m) { return m[0] != 0 ? 1u : 0u; }
#endif

inline TubeHits intersect_text(TubeBlock& block, std::size_t count, const TubeSegment& segment) {
  constexpr double largest = std::numeric_limits<double>::max();
  // As length_of() has it.
  constexpr double lowest = std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  const Doubles zero = {}, one = all(1.0), segment_begin = all(segment.begin), near = all(segment.near);
  const Doubles t_mid = all(0.5 * (segment.begin + segment.end));
  const Doubles root_delta = all(__builtin_sqrt(segment.delta));
  TubeHits hits;
  for (std::size_t i = 0; i < count; i += SWEPT_TUBE_LANES) {
    const Doubles u = load(block.u + i), v = load(block.v + i), z = load(block.z + i);
    const Doubles du = load(block.du + i), dv = load(block.dv + i), dz = load(block.dz + i);
    const Doubles square = du * du + dv * dv, speed = root(square);
    const DoubleMask still = (du == zero) & (dv == zero);
    const DoubleMask plain = still | ((square >= lowest) & (square <= largest));

    const Doubles divisor = choose(still, one, speed);
    const Doubles direction_u = du / divisor, direction_v = dv / divisor;
    const Doubles across = u * direction_v - v * direction_u;
    const Doubles along = u * direction_u + v * direction_v;
    const Doubles nearest_squared = choose(still, u * u + v * v, across * across);
    DoubleMask met = nearest_squared <= one;
    const Doubles half_chord = root((one - across) * (one + across));
    const Doubles entry = t_mid + (-half_chord - along) / divisor;
    const Doubles exit = t_mid + (half_chord - along) / divisor;
    const DoubleMask late = ~still & (entry > segment_begin), soon = ~still & (exit < segment.end);
    Doubles begin = choose(late, entry, segment_begin);
    Doubles end = choose(soon, exit, all(segment.end));
    Doubles position = choose(late, -half_chord, along + speed * (begin - t_mid));
    position = choose(still, zero, position);

    const DoubleMask comes = dz < zero, level = dz == zero;
    const Doubles crossing = t_mid + (near - z) / choose(level, one, dz);
    end = choose(comes & (crossing < end), crossing, end);
    const DoubleMask appears = ~(comes | level) & (crossing > begin);
    position = choose(appears, position + speed * (crossing - begin), position);
    begin = choose(appears, crossing, begin);
    met &= ~level | (z >= near);
    met &= begin < end;

    const Doubles rate = root_delta * speed, y_begin = root_delta * position;
    const Doubles z_begin = z + dz * (begin - t_mid);
    met &= (magnitude(z_begin) <= largest) & (magnitude(dz) <= largest) & (magnitude(y_begin) <= largest) &
           (rate <= largest);
    store(begin, block.t_begin + i);
    store(end, block.t_end + i);
    store(nearest_squared, block.nearest_squared + i);
    store(rate, block.rate + i);
    store(y_begin, block.y_begin + i);
    store(z_begin, block.z_begin + i);
    hits.met |= bits(met & plain) << i;
    hits.odd |= bits(~plain) << i;
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
