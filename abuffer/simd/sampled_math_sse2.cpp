#include "abuffer/simd/vector_sse2.h"

#include "abuffer/simd/sampled_math_text.h"

SWEPT_DEFINE_SAMPLED_MATH(sampled_math_sse2, "SSE2")
