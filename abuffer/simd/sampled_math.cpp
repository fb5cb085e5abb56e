#include "abuffer/simd/sampled_math.h"

#include "abuffer/simd/present_maths.h"

namespace swept {

extern const SampledMath sampled_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const SampledMath sampled_math_sse2, sampled_math_avx2, sampled_math_avx512;
#endif

SampledMaths sampled_maths() {
#if defined(SWEPT_SIMD) && defined(__x86_64__)
  static const PresentMaths present(sampled_math_scalar, sampled_math_sse2, sampled_math_avx2,
                                    sampled_math_avx512);
#else
  static const PresentMaths present(sampled_math_scalar);
#endif
  return {present.maths, present.count};
}

}  // namespace swept
