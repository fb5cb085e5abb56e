// Which implementations of a set of functions this processor can run.
#pragma once

#include <cstddef>

namespace swept {

/// The plain one first, the fastest last.
template <class Math>
struct PresentMaths {
  Math maths[4];
  std::size_t count = 0;

  explicit PresentMaths(const Math& plain) { maths[count++] = plain; }
#if defined(__x86_64__)
  /// `fused`: the one of AVX2 takes fused multiplication and addition, too.
  PresentMaths(const Math& plain, const Math& sse2, const Math& avx2, const Math& avx512, bool fused = false)
      : PresentMaths(plain) {
    maths[count++] = sse2;
    if (__builtin_cpu_supports("avx2") && (!fused || __builtin_cpu_supports("fma"))) maths[count++] = avx2;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) maths[count++] = avx512;
  }
#endif
};

}  // namespace swept
