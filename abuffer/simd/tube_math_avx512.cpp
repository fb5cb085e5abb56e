#define SWEPT_TUBE_LANES 8
#include "abuffer/simd/tube_math_text.h"

SWEPT_DEFINE_TUBE_MATH(tube_math_avx512, "AVX-512")
