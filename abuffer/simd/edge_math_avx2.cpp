#include "abuffer/simd/doubles_avx2.h"

#include "abuffer/simd/edge_math_text.h"

SWEPT_DEFINE_EDGE_MATH(edge_math_avx2, "AVX2")
