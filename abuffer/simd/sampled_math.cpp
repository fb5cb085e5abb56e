#include "abuffer/simd/sampled_math.h"

namespace swept {

extern const SampledMath sampled_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const SampledMath sampled_math_sse2, sampled_math_avx2, sampled_math_avx512;
#endif

SampledMaths sampled_maths() {
  static const struct Present {
    SampledMath maths[4];
    std::size_t count = 0;

    Present() {
      maths[count++] = sampled_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
      maths[count++] = sampled_math_sse2;
      if (__builtin_cpu_supports("avx2")) maths[count++] = sampled_math_avx2;
      if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
        maths[count++] = sampled_math_avx512;
#endif
    }
  } present;
  return {present.maths, present.count};
}

}  // namespace swept
