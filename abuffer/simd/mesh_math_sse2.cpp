#include "abuffer/simd/vector_sse2.h"

#include "abuffer/simd/mesh_math_text.h"

SWEPT_DEFINE_MESH_MATH(mesh_math_sse2, "SSE2")
