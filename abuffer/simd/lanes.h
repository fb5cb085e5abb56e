// Eight floats that are calculated with alike: as one vector, or, where SWEPT_PLAIN_LANES is defined, one
// after the other. Left to itself GCC 12 makes vectors of loops over eight lanes that take five times as
// long.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

// A function built for one instruction set only inlines what it is told to; and then no vector is passed in
// a way that depends on the instruction set.
#define SWEPT_INLINE [[gnu::always_inline]] inline
#pragma GCC diagnostic ignored "-Wpsabi"

namespace swept {
namespace {

#if defined(SWEPT_PLAIN_LANES)

template <class T>
struct EightOf {
  T lane[8];

  [[nodiscard]] T operator[](std::size_t i) const { return lane[i]; }
};
using Lanes = EightOf<float>;
using LaneBits = EightOf<std::uint32_t>;

template <class T, class F>
EightOf<T> by_lane(F&& f) {
  EightOf<T> result;
  for (std::size_t i = 0; i < 8; ++i) result.lane[i] = f(i);
  return result;
}
inline Lanes all(float x) {
  return by_lane<float>([&](std::size_t) { return x; });
}
inline Lanes operator+(const Lanes& a, const Lanes& b) {
  return by_lane<float>([&](std::size_t i) { return a[i] + b[i]; });
}
inline Lanes operator-(const Lanes& a, const Lanes& b) {
  return by_lane<float>([&](std::size_t i) { return a[i] - b[i]; });
}
inline Lanes operator*(const Lanes& a, const Lanes& b) {
  return by_lane<float>([&](std::size_t i) { return a[i] * b[i]; });
}
inline Lanes operator/(const Lanes& a, const Lanes& b) {
  return by_lane<float>([&](std::size_t i) { return a[i] / b[i]; });
}
inline Lanes operator+(float a, const Lanes& b) { return all(a) + b; }
inline Lanes operator-(float a, const Lanes& b) { return all(a) - b; }
inline Lanes operator*(float a, const Lanes& b) { return all(a) * b; }
inline Lanes operator+(const Lanes& a, float b) { return a + all(b); }
inline Lanes operator-(const Lanes& a, float b) { return a - all(b); }
inline Lanes operator*(const Lanes& a, float b) { return a * all(b); }
inline Lanes& operator+=(Lanes& a, const Lanes& b) { return a = a + b; }
inline Lanes operator-(const Lanes& a) {
  return by_lane<float>([&](std::size_t i) { return -a[i]; });
}
inline Lanes larger(const Lanes& a, const Lanes& b) {
  return by_lane<float>([&](std::size_t i) { return a[i] > b[i] ? a[i] : b[i]; });
}
inline Lanes smaller(const Lanes& a, const Lanes& b) {
  return by_lane<float>([&](std::size_t i) { return a[i] < b[i] ? a[i] : b[i]; });
}
inline LaneBits bits_of(const Lanes& a) {
  LaneBits bits;
  std::memcpy(&bits, &a, sizeof bits);
  return bits;
}
inline Lanes floats_of(const LaneBits& a) {
  Lanes floats;
  std::memcpy(&floats, &a, sizeof floats);
  return floats;
}
/// Of signed integers, to nearest.
inline Lanes floats_from(const LaneBits& a) {
  return by_lane<float>([&](std::size_t i) { return static_cast<float>(static_cast<std::int32_t>(a[i])); });
}
inline LaneBits operator-(std::uint32_t a, const LaneBits& b) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return a - b[i]; });
}
inline LaneBits operator&(const LaneBits& a, std::uint32_t b) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return a[i] & b; });
}
inline LaneBits operator&(const LaneBits& a, const LaneBits& b) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return a[i] & b[i]; });
}
inline LaneBits operator<<(const LaneBits& a, int b) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return a[i] << b; });
}
inline LaneBits operator+(const LaneBits& a, const LaneBits& b) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return a[i] + b[i]; });
}

using LaneTicks = EightOf<std::int32_t>;
inline LaneTicks all_ticks(std::int32_t x) {
  return by_lane<std::int32_t>([&](std::size_t) { return x; });
}
inline LaneTicks operator-(const LaneTicks& a, const LaneTicks& b) {
  return by_lane<std::int32_t>([&](std::size_t i) { return a[i] - b[i]; });
}
inline LaneTicks operator+(const LaneTicks& a, const LaneTicks& b) {
  return by_lane<std::int32_t>([&](std::size_t i) { return a[i] + b[i]; });
}
inline LaneTicks later(const LaneTicks& a, const LaneTicks& b) {
  return by_lane<std::int32_t>([&](std::size_t i) { return a[i] > b[i] ? a[i] : b[i]; });
}
inline LaneTicks sooner(const LaneTicks& a, const LaneTicks& b) {
  return by_lane<std::int32_t>([&](std::size_t i) { return a[i] < b[i] ? a[i] : b[i]; });
}
inline Lanes floats_from(const LaneTicks& a) {
  return by_lane<float>([&](std::size_t i) { return static_cast<float>(a[i]); });
}
/// All ones where a < b, or a ≤ b.
inline LaneBits below(const LaneTicks& a, const LaneTicks& b) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return a[i] < b[i] ? ~0u : 0u; });
}
inline LaneBits at_most(const Lanes& a, const Lanes& b) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return a[i] <= b[i] ? ~0u : 0u; });
}
inline LaneBits operator|(const LaneBits& a, const LaneBits& b) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return a[i] | b[i]; });
}
inline LaneBits operator~(const LaneBits& a) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return ~a[i]; });
}
inline bool any(const LaneBits& a) {
  std::uint32_t bits = 0;
  for (const std::uint32_t lane : a.lane) bits |= lane;
  return bits != 0;
}

inline float largest(const Lanes& a) {
  float value = a[0];
  for (const float other : a.lane) value = other > value ? other : value;
  return value;
}
inline float smallest(const Lanes& a) {
  float value = a[0];
  for (const float other : a.lane) value = other < value ? other : value;
  return value;
}
/// All ones in the lanes below `count`, for choose() and to cut others to zero.
inline LaneBits lanes_below(std::size_t count) {
  return by_lane<std::uint32_t>([&](std::size_t i) { return i < count ? ~0u : 0u; });
}
inline Lanes choose(const LaneBits& mask, const Lanes& a, const Lanes& b) {
  return by_lane<float>([&](std::size_t i) { return mask[i] ? a[i] : b[i]; });
}
inline LaneTicks choose(const LaneBits& mask, const LaneTicks& a, const LaneTicks& b) {
  return by_lane<std::int32_t>([&](std::size_t i) { return mask[i] ? a[i] : b[i]; });
}
inline LaneTicks first_eight() { return {{0, 1, 2, 3, 4, 5, 6, 7}}; }
inline float total(const Lanes& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}
/// Each argument's sum of lanes, added up in this order.
inline Lanes totals(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, const Lanes& e,
                    const Lanes& f, const Lanes& g, const Lanes& h) {
  const auto total = [](const Lanes& v) {
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
  };
  return {{total(a), total(b), total(c), total(d), total(e), total(f), total(g), total(h)}};
}

#else

using Lanes = float __attribute__((vector_size(32)));
using LaneBits = std::uint32_t __attribute__((vector_size(32)));

SWEPT_INLINE Lanes all(float x) { return x - Lanes{}; }
SWEPT_INLINE Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
SWEPT_INLINE Lanes smaller(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
SWEPT_INLINE LaneBits bits_of(const Lanes& a) { return (LaneBits)a; }
SWEPT_INLINE Lanes floats_of(const LaneBits& a) { return (Lanes)a; }
SWEPT_INLINE Lanes floats_from(const LaneBits& a) {
  using Integers = std::int32_t __attribute__((vector_size(32)));
  return __builtin_convertvector((Integers)a, Lanes);
}

using LaneTicks = std::int32_t __attribute__((vector_size(32)));
SWEPT_INLINE LaneTicks all_ticks(std::int32_t x) { return x - LaneTicks{}; }
SWEPT_INLINE LaneTicks later(const LaneTicks& a, const LaneTicks& b) { return a > b ? a : b; }
SWEPT_INLINE LaneTicks sooner(const LaneTicks& a, const LaneTicks& b) { return a < b ? a : b; }
SWEPT_INLINE Lanes floats_from(const LaneTicks& a) { return __builtin_convertvector(a, Lanes); }
SWEPT_INLINE LaneBits below(const LaneTicks& a, const LaneTicks& b) { return (LaneBits)(a < b); }
SWEPT_INLINE LaneBits at_most(const Lanes& a, const Lanes& b) { return (LaneBits)(a <= b); }
SWEPT_INLINE bool any(const LaneBits& a) {
  using Halves = std::uint64_t __attribute__((vector_size(32)));
  const Halves h = (Halves)a;
  return ((h[0] | h[1]) | (h[2] | h[3])) != 0;
}

SWEPT_INLINE float largest(const Lanes& a) {
  const Lanes b = larger(a, __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3));
  const Lanes c = larger(b, __builtin_shufflevector(b, b, 2, 3, 0, 1, 6, 7, 4, 5));
  return c[0] > c[1] ? c[0] : c[1];
}
SWEPT_INLINE float smallest(const Lanes& a) { return -largest(-a); }

SWEPT_INLINE LaneBits lanes_below(std::size_t count) {
  const LaneBits lane = {0, 1, 2, 3, 4, 5, 6, 7};
  const LaneBits limit = static_cast<std::uint32_t>(count < 8 ? count : 8) - LaneBits{};
  return (LaneBits)(lane < limit);
}
SWEPT_INLINE Lanes choose(const LaneBits& mask, const Lanes& a, const Lanes& b) {
  return floats_of((bits_of(a) & mask) | (bits_of(b) & ~mask));
}
SWEPT_INLINE LaneTicks choose(const LaneBits& mask, const LaneTicks& a, const LaneTicks& b) {
  return (LaneTicks)(((LaneBits)a & mask) | ((LaneBits)b & ~mask));
}
SWEPT_INLINE LaneTicks first_eight() { return LaneTicks{0, 1, 2, 3, 4, 5, 6, 7}; }

SWEPT_INLINE float total(const Lanes& a) {
  const Lanes b = a + __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3);
  const Lanes c = b + __builtin_shufflevector(b, b, 2, 3, 0, 1, 6, 7, 4, 5);
  return c[0] + c[1];
}

/// Each argument's sum of lanes, added up as ((0 + 4) + (2 + 6)) + ((1 + 5) + (3 + 7)): adds halves, quarters
/// and eighths of all arguments at once.
SWEPT_INLINE Lanes totals(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, const Lanes& e,
                          const Lanes& f, const Lanes& g, const Lanes& h) {
#define SWEPT_HALVES(x, y)                                   \
  (__builtin_shufflevector(x, y, 0, 1, 2, 3, 8, 9, 10, 11) + \
   __builtin_shufflevector(x, y, 4, 5, 6, 7, 12, 13, 14, 15))
#define SWEPT_QUARTERS(x, y)                                 \
  (__builtin_shufflevector(x, y, 0, 1, 8, 9, 4, 5, 12, 13) + \
   __builtin_shufflevector(x, y, 2, 3, 10, 11, 6, 7, 14, 15))
  const Lanes ae = SWEPT_HALVES(a, e), bf = SWEPT_HALVES(b, f), cg = SWEPT_HALVES(c, g),
              dh = SWEPT_HALVES(d, h);
  const Lanes abef = SWEPT_QUARTERS(ae, bf), cdgh = SWEPT_QUARTERS(cg, dh);
#undef SWEPT_HALVES
#undef SWEPT_QUARTERS
  return __builtin_shufflevector(abef, cdgh, 0, 2, 8, 10, 4, 6, 12, 14) +
         __builtin_shufflevector(abef, cdgh, 1, 3, 9, 11, 5, 7, 13, 15);
}

#endif

SWEPT_INLINE Lanes load(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
SWEPT_INLINE LaneBits load_bits(const float* from) { return bits_of(load(from)); }
SWEPT_INLINE LaneTicks load_ticks(const float* from) {
  LaneTicks lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
SWEPT_INLINE void store(const Lanes& lanes, float* to) { std::memcpy(to, &lanes, sizeof lanes); }
/// `a` in the lanes of `mask`, zero in the others.
SWEPT_INLINE Lanes only(const LaneBits& mask, const Lanes& a) { return floats_of(bits_of(a) & mask); }
SWEPT_INLINE Lanes magnitude(const Lanes& a) { return floats_of(bits_of(a) & 0x7fffffffu); }

}  // namespace
}  // namespace swept
