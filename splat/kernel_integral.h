// Integrals of a moving kernel over time, stably.
//
// Source: model section 3; Heinzle et al. 2010, Eq. 18 to 20. Written as Heinzle does, the integral is 0/0
// for a kernel that stands still and a difference of nearly equal numbers in the tails. Here it is the
// interval's length times the mean of exp(−y²) over [y_begin, y_end], y being the kernel's position along its
// line:
//
//   short intervals    Taylor series about the middle: one exp, no division
//   one-sided, distant  difference of erfc
//   otherwise           difference of erf
#pragma once

#include <cmath>
#include <numbers>

namespace swept {

/// The mean of exp(−y²) over [m − s/2, m + s/2] as exp(−m²) · Σ H₂ₙ(m) s²ⁿ / (4ⁿ (2n+1)!), Hₖ being the
/// Hermite polynomials.
template <class T>
struct GaussianSeries;

template <>
struct GaussianSeries<float> {
  /// Terms n ≤ 4. Where `holds`, the first one dropped is below 2⁻²³: it is at most (m s)¹⁰/11! +
  /// s¹⁰/(4⁵·5!·11).
  [[nodiscard]] static float factor(float middle, float span) {
    const float m2 = 4.0f * middle * middle;
    const float h2 = m2 - 2.0f;
    const float h4 = (m2 - 12.0f) * m2 + 12.0f;
    const float h6 = ((m2 - 30.0f) * m2 + 180.0f) * m2 - 120.0f;
    const float h8 = (((m2 - 56.0f) * m2 + 840.0f) * m2 - 3360.0f) * m2 + 1680.0f;
    const float s2 = span * span;
    return 1.0f + s2 * (h2 * (1.0f / 24.0f) +
                        s2 * (h4 * (1.0f / 1920.0f) +
                              s2 * (h6 * (1.0f / 322560.0f) + s2 * (h8 * (1.0f / 92897280.0f)))));
  }
  [[nodiscard]] static bool holds(float middle, float span) {
    return span * (1.0f + 0.8f * std::abs(middle)) <= 0.8f;
  }
};

template <>
struct GaussianSeries<double> {
  /// Terms n ≤ 11, by the recurrence Hₖ₊₁ = 2m Hₖ − 2k Hₖ₋₁. Where `holds`, the first one dropped is below
  /// 2⁻⁵³.
  [[nodiscard]] static double factor(double middle, double span) {
    double previous = 1.0, current = 2.0 * middle;  // H₀, H₁
    double scale = 1.0, sum = 1.0;
    for (int k = 1; k < 22; ++k) {
      const double next = 2.0 * middle * current - 2.0 * k * previous;
      previous = current;
      current = next;
      if (k % 2 == 0) continue;
      scale *= span * span / (4.0 * (k + 1) * (k + 2));
      sum += current * scale;
    }
    return sum;
  }
  [[nodiscard]] static bool holds(double middle, double span) {
    return span * (1.0 + 0.8 * std::abs(middle)) <= 0.8;
  }
};

/// Mean of exp(−y²) over [y_begin, y_end], y_begin ≤ y_end, both finite; exp(−y²) itself if they are equal.
/// In (0, 1], or 0 where it underflows.
template <class T>
[[nodiscard]] T mean_gaussian(T y_begin, T y_end) {
  const T span = y_end - y_begin;
  const T middle = y_begin + T(0.5) * span;
  if (GaussianSeries<T>::holds(middle, span))
    return std::exp(-middle * middle) * GaussianSeries<T>::factor(middle, span);
  constexpr T half_root_pi = T(0.5) / std::numbers::inv_sqrtpi_v<T>;
  // erfc(x) keeps its relative accuracy where erf(x) approaches one.
  T difference;
  if (y_begin > T(0.5))
    difference = std::erfc(y_begin) - std::erfc(y_end);
  else if (y_end < T(-0.5))
    difference = std::erfc(-y_end) - std::erfc(-y_begin);
  else
    difference = std::erf(y_end) - std::erf(y_begin);
  return half_root_pi * difference / span;
}

}  // namespace swept
