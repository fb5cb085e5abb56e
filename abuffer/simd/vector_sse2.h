// Four floats, by what every x86-64 processor has.
#pragma once

#include <cstddef>
#include <cstdint>

#include <emmintrin.h>

namespace swept {
namespace {

#define SWEPT_LANE [[gnu::always_inline]] inline

inline constexpr int vector_lanes = 4;

struct Vector {
  __m128 x;
};
struct Mask {
  __m128 set;
};

SWEPT_LANE Vector all(float x) { return {_mm_set1_ps(x)}; }
SWEPT_LANE Vector load(const float* from) { return {_mm_loadu_ps(from)}; }
SWEPT_LANE void store(Vector a, float* to) { _mm_storeu_ps(to, a.x); }
SWEPT_LANE Vector operator+(Vector a, Vector b) { return {_mm_add_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator-(Vector a, Vector b) { return {_mm_sub_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator*(Vector a, Vector b) { return {_mm_mul_ps(a.x, b.x)}; }
SWEPT_LANE Vector operator/(Vector a, Vector b) { return {_mm_div_ps(a.x, b.x)}; }
SWEPT_LANE Vector smaller(Vector a, Vector b) { return {_mm_min_ps(a.x, b.x)}; }
SWEPT_LANE Vector larger(Vector a, Vector b) { return {_mm_max_ps(a.x, b.x)}; }
SWEPT_LANE Vector root(Vector a) { return {_mm_sqrt_ps(a.x)}; }
SWEPT_LANE Vector magnitude(Vector a) { return {_mm_andnot_ps(_mm_set1_ps(-0.0f), a.x)}; }
SWEPT_LANE Mask operator<(Vector a, Vector b) { return {_mm_cmplt_ps(a.x, b.x)}; }
SWEPT_LANE Mask operator<=(Vector a, Vector b) { return {_mm_cmple_ps(a.x, b.x)}; }
SWEPT_LANE Mask operator==(Vector a, Vector b) { return {_mm_cmpeq_ps(a.x, b.x)}; }
SWEPT_LANE Mask operator&(Mask a, Mask b) { return {_mm_and_ps(a.set, b.set)}; }
SWEPT_LANE Mask operator|(Mask a, Mask b) { return {_mm_or_ps(a.set, b.set)}; }
SWEPT_LANE Mask without(Mask a, Mask b) { return {_mm_andnot_ps(b.set, a.set)}; }
SWEPT_LANE Vector choose(Mask m, Vector a, Vector b) {
  return {_mm_or_ps(_mm_and_ps(m.set, a.x), _mm_andnot_ps(m.set, b.x))};
}
SWEPT_LANE Vector only(Mask m, Vector a) { return {_mm_and_ps(m.set, a.x)}; }
SWEPT_LANE std::uint32_t bits(Mask m) { return static_cast<std::uint32_t>(_mm_movemask_ps(m.set)); }
SWEPT_LANE Vector exponent_from_low_bits(Vector a) {
  return {_mm_castsi128_ps(_mm_slli_epi32(_mm_castps_si128(a.x), 23))};
}
SWEPT_LANE Vector exponent_of(Vector a) {
  return {_mm_cvtepi32_ps(_mm_sub_epi32(_mm_srli_epi32(_mm_castps_si128(a.x), 23), _mm_set1_epi32(127)))};
}
SWEPT_LANE Vector mantissa_of(Vector a) {
  return {_mm_castsi128_ps(_mm_or_si128(_mm_and_si128(_mm_castps_si128(a.x), _mm_set1_epi32(0x007fffff)),
                                        _mm_set1_epi32(0x3f800000)))};
}

SWEPT_LANE Vector load_4x4(const float* from, std::ptrdiff_t pitch, int part) {
  return {_mm_loadu_ps(from + part * pitch)};
}
SWEPT_LANE void store_4x4(Vector a, float* to, std::ptrdiff_t pitch, int part) {
  _mm_storeu_ps(to + part * pitch, a.x);
}
SWEPT_LANE Vector load_8x2(const float* from, std::ptrdiff_t pitch, int part) {
  return {_mm_loadu_ps(from + (part / 2) * pitch + 4 * (part % 2))};
}
SWEPT_LANE void store_8x2(Vector a, float* to, std::ptrdiff_t pitch, int part) {
  _mm_storeu_ps(to + (part / 2) * pitch + 4 * (part % 2), a.x);
}

}  // namespace
}  // namespace swept
