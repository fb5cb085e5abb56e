#include "abuffer/simd/edge_math.h"

#include "abuffer/simd/present_maths.h"

namespace swept {

extern const EdgeMath edge_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const EdgeMath edge_math_sse2, edge_math_avx2, edge_math_avx512;
#endif

EdgeMaths edge_maths() {
#if defined(SWEPT_SIMD) && defined(__x86_64__)
  static const PresentMaths present(edge_math_scalar, edge_math_sse2, edge_math_avx2, edge_math_avx512, true);
#else
  static const PresentMaths present(edge_math_scalar);
#endif
  return {present.maths, present.count};
}

}  // namespace swept
