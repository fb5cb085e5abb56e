#include "abuffer/simd/vector_avx512.h"

#include "abuffer/simd/sampled_math_text.h"

SWEPT_DEFINE_SAMPLED_MATH(sampled_math_avx512, "AVX-512")
