// Eight doubles.
#pragma once

#include <cstdint>

#include <immintrin.h>

namespace swept {
namespace {

#define SWEPT_LANE [[gnu::always_inline]] inline

inline constexpr int double_lanes = 8;

struct Doubles {
  __m512d x;
};
struct Mask {
  __mmask8 set;
};

SWEPT_LANE Doubles all(double x) { return {_mm512_set1_pd(x)}; }
SWEPT_LANE Doubles load(const double* from) { return {_mm512_loadu_pd(from)}; }
SWEPT_LANE void store(Doubles a, double* to) { _mm512_storeu_pd(to, a.x); }
SWEPT_LANE Doubles operator+(Doubles a, Doubles b) { return {_mm512_add_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator-(Doubles a, Doubles b) { return {_mm512_sub_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator*(Doubles a, Doubles b) { return {_mm512_mul_pd(a.x, b.x)}; }
SWEPT_LANE Doubles operator/(Doubles a, Doubles b) { return {_mm512_div_pd(a.x, b.x)}; }
SWEPT_LANE Doubles fused(Doubles a, Doubles b, Doubles c) { return {_mm512_fmadd_pd(a.x, b.x, c.x)}; }
SWEPT_LANE Doubles smaller(Doubles a, Doubles b) { return {_mm512_min_pd(a.x, b.x)}; }
SWEPT_LANE Doubles larger(Doubles a, Doubles b) { return {_mm512_max_pd(a.x, b.x)}; }
SWEPT_LANE Doubles root(Doubles a) { return {_mm512_sqrt_pd(a.x)}; }
SWEPT_LANE Doubles magnitude(Doubles a) { return {_mm512_abs_pd(a.x)}; }
SWEPT_LANE Doubles negative(Doubles a) { return {_mm512_xor_pd(a.x, _mm512_set1_pd(-0.0))}; }
SWEPT_LANE Mask operator<(Doubles a, Doubles b) { return {_mm512_cmp_pd_mask(a.x, b.x, _CMP_LT_OQ)}; }
SWEPT_LANE Mask operator<=(Doubles a, Doubles b) { return {_mm512_cmp_pd_mask(a.x, b.x, _CMP_LE_OQ)}; }
SWEPT_LANE Mask operator&(Mask a, Mask b) { return {_kand_mask8(a.set, b.set)}; }
SWEPT_LANE Mask operator|(Mask a, Mask b) { return {_kor_mask8(a.set, b.set)}; }
SWEPT_LANE Mask without(Mask a, Mask b) { return {_kandn_mask8(b.set, a.set)}; }
SWEPT_LANE Doubles choose(Mask m, Doubles a, Doubles b) { return {_mm512_mask_blend_pd(m.set, b.x, a.x)}; }
SWEPT_LANE std::uint32_t bits(Mask m) { return m.set; }

}  // namespace
}  // namespace swept
