// Where polynomials change their sign within [0, 1], exactly: between the roots of their derivatives.
#pragma once

#include <vector>

#include "tests/oracle/oracle.h"

namespace swept::oracle {

/// Of Σ c[k] binomial(degree, k) tᵏ (1 − t)^(degree − k), whose coefficients are taken as exact; rising.
/// Shares no formula with splat/interval/bernstein.h: it works on powers of t.
[[nodiscard]] std::vector<Exact> sign_changes(const double* c, int degree, Digits digits = Digits::fifty);

}  // namespace swept::oracle
