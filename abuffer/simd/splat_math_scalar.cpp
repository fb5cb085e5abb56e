#include "abuffer/simd/vector_scalar.h"

#include "abuffer/simd/splat_math_text.h"

SWEPT_DEFINE_SPLAT_MATH(splat_math_scalar, "scalar")
