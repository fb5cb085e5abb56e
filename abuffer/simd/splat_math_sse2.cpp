#include "abuffer/simd/vector_sse2.h"

#include "abuffer/simd/splat_math_text.h"

SWEPT_DEFINE_SPLAT_MATH(splat_math_sse2, "SSE2")
