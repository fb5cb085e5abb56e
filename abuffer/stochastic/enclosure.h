// Bounds of Bézier curves of one variable by piecewise linear functions, and the time in which a curve may be
// at or below zero.
//
// Source: Lutterkort and Peters 1999, Tight Linear Envelopes for Splines; Gribel et al. 2013, section 4.2. A
// polynomial of degree d with coefficients b is its chord plus Σ ∇²ᵢb · aᵢ(t), aᵢ being the polynomial whose
// coefficients have the single second difference 1 at i and end at 0. All aᵢ are convex, since their second
// derivatives are d(d − 1) times Bernstein polynomials; so the chords of aᵢ between breaks lie above it, and
// the same chords lowered by how far they leave it lie below.
#pragma once

#include <algorithm>

#include "abuffer/stochastic/stochastic.h"

namespace swept::stochastic {

/// Of edge functions, of corners that move along parabolas.
inline constexpr int most_degree = 4;

/// [begin, end], empty where begin > end.
struct Span {
  double begin = 0.0, end = 1.0;

  [[nodiscard]] bool empty() const { return !(begin <= end); }
};
[[nodiscard]] inline Span meet(const Span& a, const Span& b) {
  return {std::max(a.begin, b.begin), std::min(a.end, b.end)};
}
/// The least that holds both.
[[nodiscard]] inline Span join(const Span& a, const Span& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.begin, b.begin), std::max(a.end, b.end)};
}

/// Lines between values at increasing times from 0 to 1.
struct Polyline {
  int count = 0;
  double t[most_degree + 1], v[most_degree + 1];
};

/// A slefe's lower half: values at the breaks j/degree. `degree` is 1, 2 or 4.
void slefe_below(const double* coefficients, int degree, double* values);

/// A polyline that the curve is nowhere below.
[[nodiscard]] Polyline below(const double* coefficients, int degree, CurveBounds bounds);

/// From the first to the last time at which the polyline is ≤ 0.
[[nodiscard]] Span where_not_above(const Polyline& line);

}  // namespace swept::stochastic
