#include "abuffer/simd/doubles_sse2.h"

#include "abuffer/simd/tube_math_text.h"

SWEPT_DEFINE_TUBE_MATH(tube_math_sse2, "SSE2")
