#include "abuffer/simd/vector_avx2.h"

#include "abuffer/simd/sampled_math_text.h"

SWEPT_DEFINE_SAMPLED_MATH(sampled_math_avx2, "AVX2")
