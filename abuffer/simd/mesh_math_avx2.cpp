#include "abuffer/simd/vector_avx2.h"

#include "abuffer/simd/mesh_math_text.h"

SWEPT_DEFINE_MESH_MATH(mesh_math_avx2, "AVX2")
