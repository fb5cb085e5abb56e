#include "abuffer/simd/tube_math.h"

#include "abuffer/simd/present_maths.h"

namespace swept {

extern const TubeMath tube_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const TubeMath tube_math_sse2, tube_math_avx2, tube_math_avx512;
#endif

TubeMaths tube_maths() {
#if defined(SWEPT_SIMD) && defined(__x86_64__)
  static const PresentMaths present(tube_math_scalar, tube_math_sse2, tube_math_avx2, tube_math_avx512, true);
#else
  static const PresentMaths present(tube_math_scalar);
#endif
  return {present.maths, present.count};
}

}  // namespace swept
