#include "abuffer/simd/mesh_math.h"

#include "abuffer/simd/present_maths.h"

namespace swept {

extern const MeshMath mesh_math_scalar;
#if defined(SWEPT_SIMD) && defined(__x86_64__)
extern const MeshMath mesh_math_sse2, mesh_math_avx2, mesh_math_avx512;
#endif

MeshMaths mesh_maths() {
#if defined(SWEPT_SIMD) && defined(__x86_64__)
  static const PresentMaths present(mesh_math_scalar, mesh_math_sse2, mesh_math_avx2, mesh_math_avx512);
#else
  static const PresentMaths present(mesh_math_scalar);
#endif
  return {present.maths, present.count};
}

}  // namespace swept
