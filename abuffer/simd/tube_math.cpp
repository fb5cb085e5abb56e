#include "abuffer/simd/tube_math.h"

namespace swept {

extern const TubeMath tube_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const TubeMath tube_math_sse2, tube_math_avx2, tube_math_avx512;
#endif

TubeMaths tube_maths() {
  static const struct Present {
    TubeMath maths[4];
    std::size_t count = 0;

    Present() {
      maths[count++] = tube_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
      maths[count++] = tube_math_sse2;
      if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) maths[count++] = tube_math_avx2;
      if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
        maths[count++] = tube_math_avx512;
#endif
    }
  } present;
  return {present.maths, present.count};
}

}  // namespace swept
