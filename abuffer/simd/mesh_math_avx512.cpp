#include "abuffer/simd/vector_avx512.h"

#include "abuffer/simd/mesh_math_text.h"

SWEPT_DEFINE_MESH_MATH(mesh_math_avx512, "AVX-512")
