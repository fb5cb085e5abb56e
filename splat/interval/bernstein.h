// Polynomials over [0, 1] in Bernstein form, and where their sign changes.
//
// Sources: Farin 2002, Curves and Surfaces for CAGD (evaluation, parts, products); Descartes' rule of signs,
// by which coefficients with one change of sign have one root; Sederberg and Nishita 1990 for cutting where
// they have more.
#pragma once

#include <array>
#include <cstddef>

#include "splat/export.h"

namespace SWEPT_API swept {

inline constexpr int most_bernstein_degree = 15;

/// Σ c[k] binomial(degree, k) tᵏ (1 − t)^(degree − k).
struct Bernstein {
  int degree = 0;
  std::array<double, most_bernstein_degree + 1> c{};

  [[nodiscard]] double at(double t) const;
  /// The same polynomial with `from` at 0 and `to` at 1; from ≤ to, both in [0, 1].
  [[nodiscard]] Bernstein part(double from, double to) const;
  /// The same polynomial, written with a higher degree.
  [[nodiscard]] Bernstein raised(int to_degree) const;
  [[nodiscard]] double largest() const;  ///< of |c|
};
/// Degrees add up to most_bernstein_degree at most.
[[nodiscard]] Bernstein product(const Bernstein& a, const Bernstein& b);
/// Of equal degrees.
[[nodiscard]] Bernstein difference(const Bernstein& a, const Bernstein& b);

/// The sign of a polynomial over [0, 1]: `first` (−1 or 1) from 0 to at[0], the other one to at[1], and so
/// on. Roots at which it keeps its sign are not among them. 0: the polynomial is zero throughout.
struct SignChanges {
  int first = 0;
  int count = 0;
  std::array<double, most_bernstein_degree> at{};  ///< in [0, 1], none below the one before

  /// Of the k-th stretch, 0 ≤ k ≤ count.
  [[nodiscard]] int sign(int k) const { return k % 2 == 0 ? first : -first; }
  [[nodiscard]] int sign_at(double t) const {
    int k = 0;
    while (k < count && at[static_cast<std::size_t>(k)] <= t) ++k;
    return sign(k);
  }
};

/// By cutting in half until Descartes' rule leaves one root or none, which is then closed in on: any degree.
/// It errs where the polynomial is at most about 2⁻⁴⁸ of its largest coefficient, and nowhere else: there two
/// changes may be missed or seen. Numbers that are not finite give a zero polynomial.
[[nodiscard]] SignChanges sign_changes_by_cutting(const Bernstein& polynomial);

/// In closed form; degree ≤ 2 or 4. Of degree 2 roots are right to a few ulp of t for the coefficients as
/// they are, double roots among them. Of degree 4 (Ferrari, polished) it errs as the other does, where three
/// roots or four are nearly one below 2⁻⁴² of the largest coefficient. Other degrees are cut.
[[nodiscard]] SignChanges sign_changes_closed(const Bernstein& polynomial);

/// What sign_changes_closed() finds for degree 2, of finite coefficients c[0..2] that have not all one sign,
/// are not all 0 and whose squares are in range: how many times `at` there are. The first sign is that of the
/// first coefficient that is not 0.
[[nodiscard]] int quadratic_sign_changes(const double* c, double* at);

/// Whichever is better for the degree.
[[nodiscard]] inline SignChanges sign_changes(const Bernstein& polynomial) {
  return polynomial.degree <= 2 ? sign_changes_closed(polynomial) : sign_changes_by_cutting(polynomial);
}

}  // namespace swept
