// Four doubles.
#pragma once

#include <cstdint>

#include <immintrin.h>

namespace swept {
namespace {

#define SWEPT_LANE [[gnu::always_inline]] inline

inline constexpr int double_lanes = 4;

struct Doubles {
  __m256d x;
};
struct Mask {
  __m256d set;
};

SWEPT_LANE Doubles all(double x) { return {_mm256_set1_pd(x)}; }
SWEPT_LANE Doubles load(const double* from) { return {_mm256_loadu_pd(from)}; }
SWEPT_LANE void store(Doubles a, double* to) { _mm256_storeu_pd(to, a.x); }
SWEPT_LANE Doubles operator+(Doubles a, Doubles b) { return {_mm256_add_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator-(Doubles a, Doubles b) { return {_mm256_sub_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator*(Doubles a, Doubles b) { return {_mm256_mul_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator/(Doubles a, Doubles b) { return {_mm256_div_pd(a.x, b.x)}; }
SWEPT_LANE Doubles fused(Doubles a, Doubles b, Doubles c) { return {_mm256_fmadd_pd(a.x, b.x, c.x)}; }
SWEPT_LANE Doubles smaller(Doubles a, Doubles b) { return {_mm256_min_pd(a.x, b.x)}; }
SWEPT_LANE Doubles larger(Doubles a, Doubles b) { return {_mm256_max_pd(a.x, b.x)}; }
SWEPT_LANE Doubles root(Doubles a) { return {_mm256_sqrt_pd(a.x)}; }
SWEPT_LANE Doubles magnitude(Doubles a) { return {_mm256_andnot_pd(_mm256_set1_pd(-0.0), a.x)}; }
SWEPT_LANE Doubles negative(Doubles a) { return {_mm256_xor_pd(a.x, _mm256_set1_pd(-0.0))}; }
SWEPT_LANE Mask operator<(Doubles a, Doubles b) { return {_mm256_cmp_pd(a.x, b.x, _CMP_LT_OQ)}; }
SWEPT_LANE Mask operator<=(Doubles a, Doubles b) { return {_mm256_cmp_pd(a.x, b.x, _CMP_LE_OQ)}; }
SWEPT_LANE Mask operator&(Mask a, Mask b) { return {_mm256_and_pd(a.set, b.set)}; }
SWEPT_LANE Mask operator|(Mask a, Mask b) { return {_mm256_or_pd(a.set, b.set)}; }
SWEPT_LANE Mask without(Mask a, Mask b) { return {_mm256_andnot_pd(b.set, a.set)}; }
SWEPT_LANE Doubles choose(Mask m, Doubles a, Doubles b) { return {_mm256_blendv_pd(b.x, a.x, m.set)}; }
SWEPT_LANE std::uint32_t bits(Mask m) { return static_cast<std::uint32_t>(_mm256_movemask_pd(m.set)); }

}  // namespace
}  // namespace swept
