#include "abuffer/simd/vector_avx2.h"

#include "abuffer/simd/splat_math_text.h"

SWEPT_DEFINE_SPLAT_MATH(splat_math_avx2, "AVX2")
