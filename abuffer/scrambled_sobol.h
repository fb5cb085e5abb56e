// Sobol's sequence, scrambled as Owen 1995 does by the hash of Laine and Karras 2011. For the project's own
// sources.
//
// Its points fill any number of dimensions evenly and jointly, whichever power of two of them is taken from
// the first on, and so do the next as many; scrambled they are where chance puts them within that.
#pragma once

#include <cstdint>
#include <initializer_list>

namespace swept {

[[nodiscard]] inline std::uint32_t reversed_digits(std::uint32_t v) {
  v = v >> 16 | v << 16;
  v = (v & 0xff00ff00U) >> 8 | (v & 0x00ff00ffU) << 8;
  v = (v & 0xf0f0f0f0U) >> 4 | (v & 0x0f0f0f0fU) << 4;
  v = (v & 0xccccccccU) >> 2 | (v & 0x33333333U) << 2;
  return (v & 0xaaaaaaaaU) >> 1 | (v & 0x55555555U) << 1;
}

/// Every digit flipped or not as the digits before it say. From the digits in reverse and back to their
/// order.
[[nodiscard]] inline std::uint32_t scrambled(std::uint32_t digits_in_reverse, std::uint32_t seed) {
  std::uint32_t v = digits_in_reverse + seed;
  v ^= v * 0x6c50b47cU;
  v ^= v * 0xb82f1e52U;
  v ^= v * 0xc7afe638U;
  v ^= v * 0x8d22f6e6U;
  return reversed_digits(v);
}

/// In [0, 1).
[[nodiscard]] inline float unit_interval(std::uint32_t v) { return static_cast<float>(v >> 8) * 0x1p-24f; }

/// The second to the fourth dimension; the first is the index with its digits reversed.
class SobolDirections {
 public:
  SobolDirections() {
    fill(1, 0, {1}, directions_[0]);
    fill(2, 1, {1, 3}, directions_[1]);
    fill(3, 1, {1, 3, 1}, directions_[2]);
  }

  /// Of point `index`, before it is scrambled.
  void at(std::uint32_t index, std::uint32_t (&sobol)[3]) const {
    sobol[0] = sobol[1] = sobol[2] = 0;
    for (std::uint32_t bits = index, d = 0; bits != 0; bits >>= 1, ++d)
      if ((bits & 1U) != 0)
        for (int dimension = 0; dimension < 3; ++dimension) sobol[dimension] ^= directions_[dimension][d];
  }

 private:
  /// Joe and Kuo 2008: a polynomial's degree s, its inner coefficients a, and the first s numbers m.
  static void fill(int s, std::uint32_t a, std::initializer_list<std::uint32_t> m, std::uint32_t (&v)[32]) {
    int i = 0;
    for (const std::uint32_t first : m) v[i] = first << (31 - i), ++i;
    for (; i < 32; ++i) {
      v[i] = v[i - s] ^ v[i - s] >> s;
      for (int k = 1; k < s; ++k)
        if ((a >> (s - 1 - k) & 1U) != 0) v[i] ^= v[i - k];
    }
  }

  std::uint32_t directions_[3][32];
};

}  // namespace swept
