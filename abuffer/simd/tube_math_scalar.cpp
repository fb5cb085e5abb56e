#include "abuffer/simd/doubles_scalar.h"

#include "abuffer/simd/tube_math_text.h"

SWEPT_DEFINE_TUBE_MATH(tube_math_scalar, "scalar")
