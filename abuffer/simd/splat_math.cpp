#include "abuffer/simd/splat_math.h"

namespace swept {

extern const SplatMath splat_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const SplatMath splat_math_sse2, splat_math_avx2, splat_math_avx512;
#endif

SplatMaths splat_maths() {
  static const struct Present {
    SplatMath maths[4];
    std::size_t count = 0;

    Present() {
      maths[count++] = splat_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
      maths[count++] = splat_math_sse2;
      if (__builtin_cpu_supports("avx2")) maths[count++] = splat_math_avx2;
      if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
        maths[count++] = splat_math_avx512;
#endif
    }
  } present;
  return {present.maths, present.count};
}

}  // namespace swept
