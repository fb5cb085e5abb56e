// Two doubles, by what every x86-64 processor has.
#pragma once

#include <cmath>
#include <cstdint>

#include <emmintrin.h>

namespace swept {
namespace {

#define SWEPT_LANE [[gnu::always_inline]] inline

inline constexpr int double_lanes = 2;

struct Doubles {
  __m128d x;
};
struct Mask {
  __m128d set;
};

SWEPT_LANE Doubles all(double x) { return {_mm_set1_pd(x)}; }
SWEPT_LANE Doubles load(const double* from) { return {_mm_loadu_pd(from)}; }
SWEPT_LANE void store(Doubles a, double* to) { _mm_storeu_pd(to, a.x); }
SWEPT_LANE Doubles operator+(Doubles a, Doubles b) { return {_mm_add_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator-(Doubles a, Doubles b) { return {_mm_sub_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator*(Doubles a, Doubles b) { return {_mm_mul_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator/(Doubles a, Doubles b) { return {_mm_div_pd(a.x, b.x)}; }
SWEPT_LANE Doubles fused(Doubles a, Doubles b, Doubles c) {
  double x[2], y[2], z[2];
  store(a, x), store(b, y), store(c, z);
  return {_mm_set_pd(std::fma(x[1], y[1], z[1]), std::fma(x[0], y[0], z[0]))};
}
SWEPT_LANE Doubles smaller(Doubles a, Doubles b) { return {_mm_min_pd(a.x, b.x)}; }
SWEPT_LANE Doubles larger(Doubles a, Doubles b) { return {_mm_max_pd(a.x, b.x)}; }
SWEPT_LANE Doubles root(Doubles a) { return {_mm_sqrt_pd(a.x)}; }
SWEPT_LANE Doubles magnitude(Doubles a) { return {_mm_andnot_pd(_mm_set1_pd(-0.0), a.x)}; }
SWEPT_LANE Doubles negative(Doubles a) { return {_mm_xor_pd(a.x, _mm_set1_pd(-0.0))}; }
SWEPT_LANE Mask operator<(Doubles a, Doubles b) { return {_mm_cmplt_pd(a.x, b.x)}; }
SWEPT_LANE Mask operator<=(Doubles a, Doubles b) { return {_mm_cmple_pd(a.x, b.x)}; }
SWEPT_LANE Mask operator&(Mask a, Mask b) { return {_mm_and_pd(a.set, b.set)}; }
SWEPT_LANE Mask operator|(Mask a, Mask b) { return {_mm_or_pd(a.set, b.set)}; }
SWEPT_LANE Mask without(Mask a, Mask b) { return {_mm_andnot_pd(b.set, a.set)}; }
SWEPT_LANE Doubles choose(Mask m, Doubles a, Doubles b) {
  return {_mm_or_pd(_mm_and_pd(m.set, a.x), _mm_andnot_pd(m.set, b.x))};
}
SWEPT_LANE std::uint32_t bits(Mask m) { return static_cast<std::uint32_t>(_mm_movemask_pd(m.set)); }

}  // namespace
}  // namespace swept
