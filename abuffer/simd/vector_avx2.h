// Eight floats.
#pragma once

#include <cstddef>
#include <cstdint>

#include <immintrin.h>

namespace swept {
namespace {

#define SWEPT_LANE [[gnu::always_inline]] inline

inline constexpr int vector_lanes = 8;

struct Vector {
  __m256 x;
};
struct Mask {
  __m256 set;
};

SWEPT_LANE Vector all(float x) { return {_mm256_set1_ps(x)}; }
SWEPT_LANE Vector load(const float* from) { return {_mm256_loadu_ps(from)}; }
SWEPT_LANE void store(Vector a, float* to) { _mm256_storeu_ps(to, a.x); }
SWEPT_LANE Vector operator+(Vector a, Vector b) { return {_mm256_add_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator-(Vector a, Vector b) { return {_mm256_sub_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator*(Vector a, Vector b) { return {_mm256_mul_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator/(Vector a, Vector b) { return {_mm256_div_ps(a.x, b.x)}; }
SWEPT_LANE Vector smaller(Vector a, Vector b) { return {_mm256_min_ps(a.x, b.x)}; }
SWEPT_LANE Vector larger(Vector a, Vector b) { return {_mm256_max_ps(a.x, b.x)}; }
SWEPT_LANE Vector root(Vector a) { return {_mm256_sqrt_ps(a.x)}; }
SWEPT_LANE Vector magnitude(Vector a) { return {_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.x)}; }
SWEPT_LANE Mask operator<(Vector a, Vector b) { return {_mm256_cmp_ps(a.x, b.x, _CMP_LT_OQ)}; }
SWEPT_LANE Mask operator<=(Vector a, Vector b) { return {_mm256_cmp_ps(a.x, b.x, _CMP_LE_OQ)}; }
SWEPT_LANE Mask operator==(Vector a, Vector b) { return {_mm256_cmp_ps(a.x, b.x, _CMP_EQ_OQ)}; }
SWEPT_LANE Mask operator&(Mask a, Mask b) { return {_mm256_and_ps(a.set, b.set)}; }
SWEPT_LANE Mask operator|(Mask a, Mask b) { return {_mm256_or_ps(a.set, b.set)}; }
SWEPT_LANE Mask without(Mask a, Mask b) { return {_mm256_andnot_ps(b.set, a.set)}; }
SWEPT_LANE Vector choose(Mask m, Vector a, Vector b) { return {_mm256_blendv_ps(b.x, a.x, m.set)}; }
SWEPT_LANE Vector only(Mask m, Vector a) { return {_mm256_and_ps(m.set, a.x)}; }
SWEPT_LANE std::uint32_t bits(Mask m) { return static_cast<std::uint32_t>(_mm256_movemask_ps(m.set)); }
SWEPT_LANE Vector exponent_from_low_bits(Vector a) {
  return {_mm256_castsi256_ps(_mm256_slli_epi32(_mm256_castps_si256(a.x), 23))};
}
SWEPT_LANE Vector exponent_of(Vector a) {
  return {_mm256_cvtepi32_ps(
      _mm256_sub_epi32(_mm256_srli_epi32(_mm256_castps_si256(a.x), 23), _mm256_set1_epi32(127)))};
}
SWEPT_LANE Vector mantissa_of(Vector a) {
  return {_mm256_castsi256_ps(
      _mm256_or_si256(_mm256_and_si256(_mm256_castps_si256(a.x), _mm256_set1_epi32(0x007fffff)),
                      _mm256_set1_epi32(0x3f800000)))};
}

SWEPT_LANE Vector load_4x4(const float* from, std::ptrdiff_t pitch, int part) {
  const float* row = from + 2 * part * pitch;
  return {_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(row)), _mm_loadu_ps(row + pitch), 1)};
}
SWEPT_LANE void store_4x4(Vector a, float* to, std::ptrdiff_t pitch, int part) {
  float* row = to + 2 * part * pitch;
  _mm_storeu_ps(row, _mm256_castps256_ps128(a.x));
  _mm_storeu_ps(row + pitch, _mm256_extractf128_ps(a.x, 1));
}
SWEPT_LANE Vector load_8x2(const float* from, std::ptrdiff_t pitch, int part) {
  return {_mm256_loadu_ps(from + part * pitch)};
}
SWEPT_LANE void store_8x2(Vector a, float* to, std::ptrdiff_t pitch, int part) {
  _mm256_storeu_ps(to + part * pitch, a.x);
}

}  // namespace
}  // namespace swept
