#include "abuffer/simd/vector_scalar.h"

#include "abuffer/simd/mesh_math_text.h"

SWEPT_DEFINE_MESH_MATH(mesh_math_scalar, "scalar")
