#include "abuffer/stochastic/enclosure.h"

#include <cassert>

namespace swept::stochastic {
namespace {

/// aᵢ of one degree at the breaks, from above and below.
struct Slefe {
  double upper[most_degree][most_degree + 1] = {}, lower[most_degree][most_degree + 1] = {};
};

/// De Casteljau.
double value_of(const double* coefficients, int degree, double t) {
  double b[most_degree + 1];
  std::copy(coefficients, coefficients + degree + 1, b);
  for (int level = degree; level > 0; --level)
    for (int k = 0; k < level; ++k) b[k] += t * (b[k + 1] - b[k]);
  return b[0];
}

Slefe slefe_of(int degree) {
  Slefe slefe;
  for (int i = 1; i < degree; ++i) {
    double c[most_degree + 1];
    for (int k = 0; k <= degree; ++k)
      c[k] = -static_cast<double>(std::min(k, i) * (degree - std::max(k, i))) / degree;
    for (int j = 0; j <= degree; ++j)
      slefe.upper[i][j] = value_of(c, degree, static_cast<double>(j) / degree);
    double gap[most_degree];  // of the chord to the convex function, at most, per stretch
    for (int j = 0; j < degree; ++j) {
      const double begin = static_cast<double>(j) / degree, width = 1.0 / degree;
      const double from = slefe.upper[i][j], to = slefe.upper[i][j + 1];
      const auto gap_at = [&](double x) {
        return from + x * (to - from) - value_of(c, degree, begin + x * width);
      };
      // The gap is concave: thirds close in on its top, and what is left is below the last step's square.
      double low = 0.0, high = 1.0;
      for (int step = 0; step < 60; ++step) {
        const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
        (gap_at(a) < gap_at(b) ? low : high) = gap_at(a) < gap_at(b) ? a : b;
      }
      gap[j] = gap_at(0.5 * (low + high)) + 1e-12;
    }
    for (int j = 0; j <= degree; ++j)
      slefe.lower[i][j] = slefe.upper[i][j] - std::max(gap[std::max(0, j - 1)], gap[std::min(degree - 1, j)]);
  }
  return slefe;
}

const Slefe& slefe(int degree) {
  static const Slefe quadratic = slefe_of(2), quartic = slefe_of(4);
  return degree == 2 ? quadratic : quartic;
}

/// The lower half of the convex hull of the control polygon (Andrew's monotone chain).
Polyline lower_hull(const double* coefficients, int degree) {
  Polyline line;
  for (int k = 0; k <= degree; ++k) {
    const double t = static_cast<double>(k) / degree, v = coefficients[k];
    while (line.count >= 2) {
      const int a = line.count - 2, b = line.count - 1;
      if ((line.v[b] - line.v[a]) * (t - line.t[a]) < (v - line.v[a]) * (line.t[b] - line.t[a])) break;
      --line.count;
    }
    line.t[line.count] = t;
    line.v[line.count++] = v;
  }
  return line;
}

}  // namespace

void slefe_below(const double* b, int degree, double* values) {
  assert(degree == 1 || degree == 2 || degree == 4);
  for (int j = 0; j <= degree; ++j) values[j] = b[0] + (b[degree] - b[0]) * (static_cast<double>(j) / degree);
  if (degree == 1) return;
  const Slefe& table = slefe(degree);
  for (int i = 1; i < degree; ++i) {
    const double second = b[i - 1] - 2.0 * b[i] + b[i + 1];
    const double* const share = second >= 0.0 ? table.lower[i] : table.upper[i];
    for (int j = 0; j <= degree; ++j) values[j] += second * share[j];
  }
}

Polyline below(const double* coefficients, int degree, CurveBounds bounds) {
  if (bounds == CurveBounds::hulls) return lower_hull(coefficients, degree);
  Polyline line;
  line.count = degree + 1;
  for (int j = 0; j <= degree; ++j) line.t[j] = static_cast<double>(j) / degree;
  slefe_below(coefficients, degree, line.v);
  return line;
}

Span where_not_above(const Polyline& line) {
  Span span{1.0, 0.0};
  const int last = line.count - 1;
  int first_below = 0;
  while (first_below <= last && line.v[first_below] > 0.0) ++first_below;
  if (first_below > last) return span;
  int last_below = last;
  while (line.v[last_below] > 0.0) --last_below;
  const auto crossing = [&](int above, int below) {
    return line.t[above] +
           (line.t[below] - line.t[above]) * (line.v[above] / (line.v[above] - line.v[below]));
  };
  span.begin = first_below == 0 ? 0.0 : crossing(first_below - 1, first_below);
  span.end = last_below == last ? 1.0 : crossing(last_below + 1, last_below);
  return span;
}

}  // namespace swept::stochastic
