#include "abuffer/simd/doubles_avx512.h"

#include "abuffer/simd/tube_math_text.h"

SWEPT_DEFINE_TUBE_MATH(tube_math_avx512, "AVX-512")
