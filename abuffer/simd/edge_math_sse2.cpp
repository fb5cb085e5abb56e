#include "abuffer/simd/doubles_sse2.h"

#include "abuffer/simd/edge_math_text.h"

SWEPT_DEFINE_EDGE_MATH(edge_math_sse2, "SSE2")
