#include "abuffer/simd/doubles_avx2.h"

#include "abuffer/simd/tube_math_text.h"

SWEPT_DEFINE_TUBE_MATH(tube_math_avx2, "AVX2")
