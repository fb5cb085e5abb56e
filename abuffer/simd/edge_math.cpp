#include "abuffer/simd/edge_math.h"

namespace swept {

extern const EdgeMath edge_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const EdgeMath edge_math_sse2, edge_math_avx2, edge_math_avx512;
#endif

EdgeMaths edge_maths() {
  static const struct Present {
    EdgeMath maths[4];
    std::size_t count = 0;

    Present() {
      maths[count++] = edge_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
      maths[count++] = edge_math_sse2;
      if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) maths[count++] = edge_math_avx2;
      if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
        maths[count++] = edge_math_avx512;
#endif
    }
  } present;
  return {present.maths, present.count};
}

}  // namespace swept
