// One float at a time: the definition that the vectors of the other instruction sets are held to.
#pragma once

#include <cstdint>
#include <cstring>

namespace swept {
namespace {

inline constexpr int vector_lanes = 1;

struct Vector {
  float x;
};
struct Mask {
  bool set;
};

inline Vector all(float x) { return {x}; }
inline Vector load(const float* from) { return {*from}; }
inline void store(Vector a, float* to) { *to = a.x; }
inline Vector operator+(Vector a, Vector b) { return {a.x + b.x}; }
inline Vector operator-(Vector a, Vector b) { return {a.x - b.x}; }
inline Vector operator*(Vector a, Vector b) { return {a.x * b.x}; }
inline Vector operator/(Vector a, Vector b) { return {a.x / b.x}; }
/// The second where either is not a number, as the vectors' instructions have it.
inline Vector smaller(Vector a, Vector b) { return {a.x < b.x ? a.x : b.x}; }
inline Vector larger(Vector a, Vector b) { return {a.x > b.x ? a.x : b.x}; }
inline Vector root(Vector a) { return {__builtin_sqrtf(a.x)}; }
inline Vector magnitude(Vector a) { return {__builtin_fabsf(a.x)}; }
inline Mask operator<(Vector a, Vector b) { return {a.x < b.x}; }
inline Mask operator<=(Vector a, Vector b) { return {a.x <= b.x}; }
inline Mask operator==(Vector a, Vector b) { return {a.x == b.x}; }
inline Mask operator&(Mask a, Mask b) { return {a.set && b.set}; }
inline Mask operator|(Mask a, Mask b) { return {a.set || b.set}; }
inline Mask without(Mask a, Mask b) { return {a.set && !b.set}; }
inline Vector choose(Mask m, Vector a, Vector b) { return m.set ? a : b; }
inline Vector only(Mask m, Vector a) { return {m.set ? a.x : 0.0f}; }
inline std::uint32_t bits(Mask m) { return m.set ? 1u : 0u; }
/// The float whose bits are those of `a` moved up by 23.
inline Vector exponent_from_low_bits(Vector a) {
  std::uint32_t word;
  std::memcpy(&word, &a.x, sizeof word);
  word <<= 23;
  std::memcpy(&a.x, &word, sizeof word);
  return a;
}

/// Of a positive normal a = 2^e · m with m in [1, 2): e and m.
inline Vector exponent_of(Vector a) {
  std::uint32_t word;
  std::memcpy(&word, &a.x, sizeof word);
  return {static_cast<float>(static_cast<std::int32_t>(word >> 23) - 127)};
}
inline Vector mantissa_of(Vector a) {
  std::uint32_t word;
  std::memcpy(&word, &a.x, sizeof word);
  word = (word & 0x007fffffu) | 0x3f800000u;
  std::memcpy(&a.x, &word, sizeof word);
  return a;
}

/// Lane `part` of the 4 × 4 or 8 × 2 floats that begin at `from`.
inline Vector load_4x4(const float* from, std::ptrdiff_t pitch, int part) {
  return {from[(part / 4) * pitch + part % 4]};
}
inline void store_4x4(Vector a, float* to, std::ptrdiff_t pitch, int part) {
  to[(part / 4) * pitch + part % 4] = a.x;
}
inline Vector load_8x2(const float* from, std::ptrdiff_t pitch, int part) {
  return {from[(part / 8) * pitch + part % 8]};
}
inline void store_8x2(Vector a, float* to, std::ptrdiff_t pitch, int part) {
  to[(part / 8) * pitch + part % 8] = a.x;
}

}  // namespace
}  // namespace swept
