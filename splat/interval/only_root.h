// The root of a polynomial in Bernstein form whose coefficients change their sign once. For the project's own
// sources.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "splat/interval/bernstein.h"

namespace swept {

inline constexpr std::array<std::array<double, most_bernstein_degree + 1>, most_bernstein_degree + 1>
    bernstein_binomials = [] {
      std::array<std::array<double, most_bernstein_degree + 1>, most_bernstein_degree + 1> b{};
      for (std::size_t n = 0; n < b.size(); ++n) {
        b[n][0] = 1.0;
        for (std::size_t k = 1; k <= n; ++k) b[n][k] = b[n - 1][k - 1] + (k < n ? b[n - 1][k] : 0.0);
      }
      return b;
    }();

inline int sign_of(double v) { return v > 0.0 ? 1 : v < 0.0 ? -1 : 0; }

/// Of coefficients, but for those that are 0.
struct CoefficientSigns {
  int first = 0, last = 0, changes = 0;
};

inline CoefficientSigns signs_of(const double* c, std::size_t count) {
  CoefficientSigns s;
  for (std::size_t k = 0; k < count; ++k) {
    const int sign = sign_of(c[k]);
    if (sign == 0) continue;
    if (s.first == 0) s.first = sign;
    if (s.last != 0 && sign != s.last) ++s.changes;
    s.last = sign;
  }
  return s;
}

/// Where Σ c[k] binomial(degree, k) tᵏ (1 − t)^(degree − k) is 0, whose sign is `first` before: Newton's
/// steps, halves of the bracket where they leave it or are not at least twice as short as the one before the
/// last. `fixed` is the degree, or 0 where it is not known when this is compiled; that changes no operation.
template <int fixed>
double only_root(const double* c, int degree, int first) {
  const std::size_t n = static_cast<std::size_t>(fixed > 0 ? fixed : degree) + 1;
  constexpr std::size_t room = fixed > 0 ? fixed + 1 : most_bernstein_degree + 1;
  const auto& binomial = bernstein_binomials[n - 1];
  const auto& of_slope = bernstein_binomials[n - 2];
  double weighted[room] = {}, slope[room] = {};
  for (std::size_t k = 0; k < n; ++k) weighted[k] = binomial[k] * c[k];
  for (std::size_t k = 0; k + 1 < n; ++k)
    slope[k] = of_slope[k] * (static_cast<double>(n - 1) * (c[k + 1] - c[k]));
  const auto at = [](const double* of, std::size_t last, double t) {
    const double u = 1.0 - t;
    if (last == 0) return of[0];
    double power = 1.0, sum = of[0] * u;
    for (std::size_t k = 1; k < last; ++k) {
      power *= t;
      sum = (sum + power * of[k]) * u;
    }
    return sum + power * t * of[last];
  };
  double low = 0.0, high = 1.0, t = 0.5;
  // A chord is a better beginning than the middle.
  const double c0 = c[0], cn = c[n - 1];
  if (sign_of(c0) * sign_of(cn) < 0) t = c0 / (c0 - cn);
  double before = 2.0, step = 1.0, step_before = 1.0;
  for (int steps = 0; steps < 120; ++steps) {
    const double v = at(weighted, n - 1, t);
    if (v == 0.0) return t;
    (sign_of(v) == first ? low : high) = t;
    const double by = v / at(slope, n - 2, t);
    double next = t - by;
    if (!(next >= low && next <= high) || !(std::abs(by) <= 0.5 * std::abs(step_before)))
      next = 0.5 * (low + high);
    step_before = step;
    step = next - t;
    if (next == t || next == before || high - low <= 0x1p-53 * high) return next;
    before = t;
    t = next;
  }
  return t;
}

}  // namespace swept
