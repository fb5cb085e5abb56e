// What the texts of the sampled engine share: rounding and the exponential, lane by lane. Include after a
// vector_*.h.
#pragma once

#include "abuffer/simd/sampled_math.h"

namespace swept {
namespace {

#ifndef SWEPT_LANE
#define SWEPT_LANE inline
#endif

inline constexpr int vector_parts = packet_size / vector_lanes;
inline constexpr float infinity = __builtin_inff();

/// Adding and subtracting it rounds to whole numbers, halves to even, below 2²².
inline constexpr float rounder = 12582912.0f;

SWEPT_LANE Vector rounded(Vector a) { return (a + all(rounder)) - all(rounder); }
SWEPT_LANE Vector floor_of(Vector a) {
  const Vector r = rounded(a);
  return r - only(a < r, all(1.0f));
}

/// e^x for x in [−80, 0], within 1 ulp.
SWEPT_LANE Vector exp_of(Vector x) {
  // 2^(n + f), |f| ≤ ½; n + 127 stands in the low bits of the sum and becomes an exponent.
  const Vector t = x * all(1.44269504f);
  const Vector shifted = t + all(rounder + 127.0f);
  const Vector n = shifted - all(rounder + 127.0f);
  // Cody and Waite: the remainder x − n ln 2 in two steps.
  const Vector r = (x - n * all(0.693359375f)) - n * all(-2.12194440e-4f);
  Vector p = all(1.9875691500e-4f);
  p = p * r + all(1.3981999507e-3f);
  p = p * r + all(8.3334519073e-3f);
  p = p * r + all(4.1665795894e-2f);
  p = p * r + all(1.6666665459e-1f);
  p = p * r + all(5.0000001201e-1f);
  p = (p * r) * r + r + all(1.0f);
  return p * exponent_from_low_bits(shifted);
}

}  // namespace
}  // namespace swept
