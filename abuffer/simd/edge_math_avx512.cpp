#include "abuffer/simd/doubles_avx512.h"

#include "abuffer/simd/edge_math_text.h"

SWEPT_DEFINE_EDGE_MATH(edge_math_avx512, "AVX-512")
