#include "abuffer/resolve/depth_changes.h"

#include <cmath>

namespace swept {
namespace {

constexpr std::size_t points = DepthChanges::points, checks = DepthChanges::checks;
constexpr std::size_t degree = points - 1;
using Row = std::array<double, points>;

/// The Bernstein polynomials at t.
constexpr Row weights(double t) {
  Row row{};
  row[0] = 1.0;
  for (std::size_t n = 1; n <= degree; ++n)
    for (std::size_t k = n + 1; k-- > 0;)
      row[k] = (k > 0 ? t * row[k - 1] : 0.0) + (k < n ? (1.0 - t) * row[k] : 0.0);
  return row;
}

struct Tables {
  std::array<Row, points> coefficients{};  ///< of values
  std::array<Row, checks> at_checks{};     ///< of coefficients

  constexpr Tables() {
    std::array<Row, points> rows{};
    for (std::size_t i = 0; i < points; ++i) {
      rows[i] = weights(DepthChanges::places[i]);
      coefficients[i][i] = 1.0;
    }
    // Gauss and Jordan: what makes rows the identity makes this its inverse. Diagonals are not 0 there.
    for (std::size_t i = 0; i < points; ++i) {
      const double divisor = rows[i][i];
      for (std::size_t k = 0; k < points; ++k) rows[i][k] /= divisor, coefficients[i][k] /= divisor;
      for (std::size_t j = 0; j < points; ++j) {
        if (j == i) continue;
        const double share = rows[j][i];
        for (std::size_t k = 0; k < points; ++k) {
          rows[j][k] -= share * rows[i][k];
          coefficients[j][k] -= share * coefficients[i][k];
        }
      }
    }
    for (std::size_t i = 0; i < checks; ++i) at_checks[i] = weights(DepthChanges::places[points + i]);
  }
};
constexpr Tables tables;

}  // namespace

bool DepthChanges::fit(const Values& values, double depth, Bernstein& through) {
  double most = 0.0;
  for (const double v : values) {
    if (!std::isfinite(v)) return false;
    most = std::max(most, std::abs(v));
  }
  through.degree = static_cast<int>(degree);
  for (std::size_t k = 0; k < points; ++k) {
    through.c[k] = 0.0;
    for (std::size_t i = 0; i < points; ++i) through.c[k] += tables.coefficients[k][i] * values[i];
  }
  for (std::size_t i = 0; i < checks; ++i) {
    double at = 0.0;
    for (std::size_t k = 0; k < points; ++k) at += tables.at_checks[i][k] * through.c[k];
    if (!(std::abs(at - values[points + i]) <= off * most + rounding * depth)) return false;
  }
  return true;
}

void DepthChanges::add(const Values& values, double depth, const Bernstein& through, double begin, double end,
                       std::vector<double>& times) {
  double most = 0.0;
  for (const double v : values) most = std::max(most, std::abs(v));
  if (!(most > 100.0 * rounding * depth)) return;
  const SignChanges changes = sign_changes(through);
  for (int k = 0; k < changes.count; ++k)
    times.push_back(begin + (end - begin) * changes.at[static_cast<std::size_t>(k)]);
}

}  // namespace swept
