// A function that is smooth over a part of the exposure, by its values at Gauss and Legendre's five points:
// the polynomial of degree 4 that goes through them, and its integral, which holds to degree 9.
#pragma once

#include <array>
#include <cstddef>

namespace swept {

inline constexpr std::size_t smooth_points = 5;

namespace smooth_part {

/// Where they lie, as shares of the part, and what each weighs.
inline constexpr std::array<double, smooth_points> at = {0.04691007703066800360, 0.23076534494715845448, 0.5,
                                                         0.76923465505284154552, 0.95308992296933199640};
inline constexpr std::array<double, smooth_points> weight = {0.11846344252809454376, 0.23931433524968323402,
                                                             0.28444444444444444444, 0.23931433524968323402,
                                                             0.11846344252809454376};

/// Legendre's polynomials at `x` in [−1, 1].
constexpr std::array<double, smooth_points> legendre(double x) {
  const double s = x * x;
  return {1.0, x, 1.5 * s - 0.5, x * (2.5 * s - 1.5), s * (4.375 * s - 3.75) + 0.375};
}

/// By what the values are multiplied to give the share of the polynomial of each degree.
inline constexpr auto shares = [] {
  std::array<std::array<double, smooth_points>, smooth_points> table{};
  for (std::size_t degree = 0; degree < smooth_points; ++degree)
    for (std::size_t k = 0; k < smooth_points; ++k)
      table[degree][k] =
          (2.0 * static_cast<double>(degree) + 1.0) * weight[k] * legendre(2.0 * at[k] - 1.0)[degree];
  return table;
}();

}  // namespace smooth_part

struct SmoothPart {
  std::array<double, smooth_points> v;

  [[nodiscard]] double mean() const {
    double sum = 0.0;
    for (std::size_t k = 0; k < smooth_points; ++k) sum += smooth_part::weight[k] * v[k];
    return sum;
  }
  /// What it has of Legendre's polynomial of that degree. What it lacks of the next ones is less than the
  /// last by about as much as that is less than the one before.
  [[nodiscard]] double share(std::size_t degree) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < smooth_points; ++k) sum += smooth_part::shares[degree][k] * v[k];
    return sum;
  }
  /// The same polynomial from `from` to `to`, shares of this part.
  [[nodiscard]] SmoothPart part(double from, double to) const {
    std::array<double, smooth_points> of_degree;
    for (std::size_t degree = 0; degree < smooth_points; ++degree) of_degree[degree] = share(degree);
    SmoothPart of;
    for (std::size_t k = 0; k < smooth_points; ++k) {
      const std::array<double, smooth_points> p =
          smooth_part::legendre(2.0 * (from + smooth_part::at[k] * (to - from)) - 1.0);
      double sum = 0.0;
      for (std::size_t degree = 0; degree < smooth_points; ++degree) sum += of_degree[degree] * p[degree];
      of.v[k] = sum;
    }
    return of;
  }
};

}  // namespace swept
