// Sixteen floats.
#pragma once

#include <cstddef>
#include <cstdint>

#include <immintrin.h>

namespace swept {
namespace {

#define SWEPT_LANE [[gnu::always_inline]] inline

inline constexpr int vector_lanes = 16;

struct Vector {
  __m512 x;
};
struct Mask {
  __mmask16 set;
};

SWEPT_LANE Vector all(float x) { return {_mm512_set1_ps(x)}; }
SWEPT_LANE Vector load(const float* from) { return {_mm512_loadu_ps(from)}; }
SWEPT_LANE void store(Vector a, float* to) { _mm512_storeu_ps(to, a.x); }
SWEPT_LANE Vector operator+(Vector a, Vector b) { return {_mm512_add_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator-(Vector a, Vector b) { return {_mm512_sub_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator*(Vector a, Vector b) { return {_mm512_mul_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator/(Vector a, Vector b) { return {_mm512_div_ps(a.x, b.x)}; }
SWEPT_LANE Vector smaller(Vector a, Vector b) { return {_mm512_min_ps(a.x, b.x)}; }
SWEPT_LANE Vector larger(Vector a, Vector b) { return {_mm512_max_ps(a.x, b.x)}; }
SWEPT_LANE Vector root(Vector a) { return {_mm512_sqrt_ps(a.x)}; }
SWEPT_LANE Vector magnitude(Vector a) { return {_mm512_abs_ps(a.x)}; }
SWEPT_LANE Mask operator<(Vector a, Vector b) { return {_mm512_cmp_ps_mask(a.x, b.x, _CMP_LT_OQ)}; }
SWEPT_LANE Mask operator<=(Vector a, Vector b) { return {_mm512_cmp_ps_mask(a.x, b.x, _CMP_LE_OQ)}; }
SWEPT_LANE Mask operator==(Vector a, Vector b) { return {_mm512_cmp_ps_mask(a.x, b.x, _CMP_EQ_OQ)}; }
SWEPT_LANE Mask operator&(Mask a, Mask b) { return {_kand_mask16(a.set, b.set)}; }
SWEPT_LANE Mask operator|(Mask a, Mask b) { return {_kor_mask16(a.set, b.set)}; }
SWEPT_LANE Mask without(Mask a, Mask b) { return {_kandn_mask16(b.set, a.set)}; }
SWEPT_LANE Vector choose(Mask m, Vector a, Vector b) { return {_mm512_mask_blend_ps(m.set, b.x, a.x)}; }
SWEPT_LANE Vector only(Mask m, Vector a) { return {_mm512_maskz_mov_ps(m.set, a.x)}; }
SWEPT_LANE std::uint32_t bits(Mask m) { return m.set; }
SWEPT_LANE Vector exponent_from_low_bits(Vector a) {
  return {_mm512_castsi512_ps(_mm512_slli_epi32(_mm512_castps_si512(a.x), 23))};
}
SWEPT_LANE Vector exponent_of(Vector a) {
  return {_mm512_cvtepi32_ps(
      _mm512_sub_epi32(_mm512_srli_epi32(_mm512_castps_si512(a.x), 23), _mm512_set1_epi32(127)))};
}
SWEPT_LANE Vector mantissa_of(Vector a) {
  return {_mm512_castsi512_ps(
      _mm512_or_si512(_mm512_and_si512(_mm512_castps_si512(a.x), _mm512_set1_epi32(0x007fffff)),
                      _mm512_set1_epi32(0x3f800000)))};
}

SWEPT_LANE Vector load_4x4(const float* from, std::ptrdiff_t pitch, int) {
  __m512 a = _mm512_castps128_ps512(_mm_loadu_ps(from));
  a = _mm512_insertf32x4(a, _mm_loadu_ps(from + pitch), 1);
  a = _mm512_insertf32x4(a, _mm_loadu_ps(from + 2 * pitch), 2);
  return {_mm512_insertf32x4(a, _mm_loadu_ps(from + 3 * pitch), 3)};
}
SWEPT_LANE void store_4x4(Vector a, float* to, std::ptrdiff_t pitch, int) {
  _mm_storeu_ps(to, _mm512_castps512_ps128(a.x));
  _mm_storeu_ps(to + pitch, _mm512_extractf32x4_ps(a.x, 1));
  _mm_storeu_ps(to + 2 * pitch, _mm512_extractf32x4_ps(a.x, 2));
  _mm_storeu_ps(to + 3 * pitch, _mm512_extractf32x4_ps(a.x, 3));
}
SWEPT_LANE Vector load_8x2(const float* from, std::ptrdiff_t pitch, int) {
  return {
      _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(from)), _mm256_loadu_ps(from + pitch), 1)};
}
SWEPT_LANE void store_8x2(Vector a, float* to, std::ptrdiff_t pitch, int) {
  _mm256_storeu_ps(to, _mm512_castps512_ps256(a.x));
  _mm256_storeu_ps(to + pitch, _mm512_extractf32x8_ps(a.x, 1));
}

}  // namespace
}  // namespace swept
