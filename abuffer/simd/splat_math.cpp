#include "abuffer/simd/splat_math.h"

#include "abuffer/simd/present_maths.h"

namespace swept {

extern const SplatMath splat_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const SplatMath splat_math_sse2, splat_math_avx2, splat_math_avx512;
#endif

SplatMaths splat_maths() {
#if defined(SWEPT_SIMD) && defined(__x86_64__)
  static const PresentMaths present(splat_math_scalar, splat_math_sse2, splat_math_avx2, splat_math_avx512);
#else
  static const PresentMaths present(splat_math_scalar);
#endif
  return {present.maths, present.count};
}

}  // namespace swept
