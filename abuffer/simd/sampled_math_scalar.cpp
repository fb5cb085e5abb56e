#include "abuffer/simd/vector_scalar.h"

#include "abuffer/simd/sampled_math_text.h"

SWEPT_DEFINE_SAMPLED_MATH(sampled_math_scalar, "scalar")
