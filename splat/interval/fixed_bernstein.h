// Polynomials in Bernstein form whose degree is known when this is compiled: the same formulas as Bernstein
// has, without its loops over degrees and room for the highest.
#pragma once

#include <array>
#include <cstddef>

namespace swept {

constexpr double binomial_of(int n, int k) {
  double b = 1.0;
  for (int i = 1; i <= k; ++i) b = b * (n - k + i) / i;
  return b;
}

template <int degree>
struct FixedBernstein {
  static constexpr int size = degree + 1;
  double c[size];

  [[nodiscard]] double at(double t) const {
    const double u = 1.0 - t;
    if constexpr (degree == 1) return u * c[0] + t * c[1];
    if constexpr (degree == 2) return u * (u * c[0] + 2.0 * t * c[1]) + t * t * c[2];
    double power = 1.0, sum = c[0] * u;
    for (int k = 1; k < degree; ++k) {
      power *= t;
      sum = (sum + power * binomial_of(degree, k) * c[k]) * u;
    }
    return sum + power * t * c[degree];
  }

  /// The same polynomial with `from` at 0 and `to` at 1; from ≤ to, both in [0, 1].
  [[nodiscard]] FixedBernstein part(double from, double to) const {
    FixedBernstein p = *this;
    if (from > 0.0)
      for (int level = 1; level < size; ++level)
        for (int k = 0; k + level < size; ++k) p.c[k] += from * (p.c[k + 1] - p.c[k]);
    if (to < 1.0) {
      const double share = from < 1.0 ? (to - from) / (1.0 - from) : 0.0;
      for (int level = 1; level < size; ++level)
        for (int k = size - 1; k >= level; --k) p.c[k] = p.c[k - 1] + share * (p.c[k] - p.c[k - 1]);
    }
    return p;
  }

  /// The same polynomial, written with the next higher degree.
  [[nodiscard]] FixedBernstein<degree + 1> raised() const {
    FixedBernstein<degree + 1> p;
    p.c[0] = c[0];
    for (int k = 1; k <= degree; ++k) {
      const double share = static_cast<double>(k) / (degree + 1);
      p.c[k] = share * c[k - 1] + (1.0 - share) * c[k];
    }
    p.c[degree + 1] = c[degree];
    return p;
  }

  /// The same polynomial by powers of t: t^k times the k-th of `degree` + 1 numbers.
  void to_powers(double* powers) const {
    for (int k = 0; k < size; ++k) powers[k] = c[k];
    for (int level = 1; level < size; ++level)
      for (int k = degree; k >= level; --k) powers[k] -= powers[k - 1];
    for (int k = 1; k < size; ++k) powers[k] *= binomial_of(degree, k);
  }

  /// 1 or −1 where all coefficients are on that side of 0, else 0.
  [[nodiscard]] int side() const {
    bool above = true, below = true;
    for (const double v : c) above = above && v > 0.0, below = below && v < 0.0;
    return above ? 1 : below ? -1 : 0;
  }
};

template <int to, int from>
[[nodiscard]] FixedBernstein<to> raised_to(const FixedBernstein<from>& p) {
  if constexpr (to == from)
    return p;
  else
    return raised_to<to>(p.raised());
}

/// What coefficients i and j of factors of these degrees add to coefficient i + j of the product.
template <int a, int b>
inline constexpr auto product_shares = [] {
  std::array<std::array<double, b + 1>, a + 1> shares{};
  for (int i = 0; i <= a; ++i)
    for (int j = 0; j <= b; ++j)
      shares[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
          binomial_of(a, i) * binomial_of(b, j) / binomial_of(a + b, i + j);
  return shares;
}();

/// sum += p q.
template <int a, int b>
void add_product(const FixedBernstein<a>& p, const FixedBernstein<b>& q, FixedBernstein<a + b>& sum) {
  for (int i = 0; i <= a; ++i)
    for (int j = 0; j <= b; ++j)
      sum.c[i + j] +=
          product_shares<a, b>[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] * (p.c[i] * q.c[j]);
}

}  // namespace swept
