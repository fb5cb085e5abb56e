#include "abuffer/simd/vector_avx512.h"

#include "abuffer/simd/splat_math_text.h"

SWEPT_DEFINE_SPLAT_MATH(splat_math_avx512, "AVX-512")
