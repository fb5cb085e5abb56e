// The hot arithmetic of the sweep, over plain arrays.
#pragma once

#include <cstddef>

namespace swept {

/// mean[i] = peak[i] · mean of exp(−y²) over [y[i], y[i] + span[i]], span ≥ 0. Relative error ≤ 4 ulp + what
/// rounding of y·y costs, for |y| ≤ 8. Arrays do not overlap.
void weighted_means(const float* y, const float* span, const float* peak, float* mean, std::size_t count);

}  // namespace swept
