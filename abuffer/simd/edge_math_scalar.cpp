#include "abuffer/simd/doubles_scalar.h"

#include "abuffer/simd/edge_math_text.h"

SWEPT_DEFINE_EDGE_MATH(edge_math_scalar, "scalar")
