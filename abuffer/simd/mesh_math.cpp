#include "abuffer/simd/mesh_math.h"

namespace swept {

extern const MeshMath mesh_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const MeshMath mesh_math_sse2, mesh_math_avx2, mesh_math_avx512;
#endif

MeshMaths mesh_maths() {
  static const struct Present {
    MeshMath maths[4];
    std::size_t count = 0;

    Present() {
      maths[count++] = mesh_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
      maths[count++] = mesh_math_sse2;
      if (__builtin_cpu_supports("avx2")) maths[count++] = mesh_math_avx2;
      if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
        maths[count++] = mesh_math_avx512;
#endif
    }
  } present;
  return {present.maths, present.count};
}

}  // namespace swept
