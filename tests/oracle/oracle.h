// What the kernel's formulas are worth exactly, at 50 decimal digits, for tests and for tools/stability.
//
// Everything is computed with Boost.Multiprecision and Boost.Math from the definitions of model sections 2, 3
// and 5, sharing no formula with splat/. Inputs are taken as exact; results come back as pairs of doubles,
// about 32 digits.
#pragma once

#include <cmath>
#include <limits>

#include "splat/kernel/moving_kernel.h"
#include "splat/kernel/ray_kernel.h"

namespace swept::oracle {

/// high + low, |low| ≤ ulp(high)/2.
struct Exact {
  double high = 0.0, low = 0.0;
};

/// Precision to compute with: 113 bits, or 50 decimal digits. `quad` is quick, and 2⁻⁶⁰ of a double's
/// rounding; tests and tables compare the two as they go.
enum class Digits { quad, fifty };

/// Mean of exp(−y²) over [a, b], a ≤ b, from erf and erfc; Taylor series where that would cancel.
[[nodiscard]] Exact mean_gaussian(double a, double b, Digits digits = Digits::fifty);

/// |closed form / Gauss-Kronrod quadrature − 1| of that mean, both at 50 digits. Requires a < b and
/// min(|a|, |b|) < 27 or opposite signs.
[[nodiscard]] double quadrature_disagreement(double a, double b);

/// Where in [a, b] the weight exp(−y²) has its centre: from the middle, in units of b − a. Requires a < b. A
/// difference that loses as many digits as 1/(b − a)² has.
[[nodiscard]] Exact gaussian_centroid(double a, double b, Digits digits = Digits::fifty);

/// Coordinates along the ray (x, y, 1), by Cramer's rule on o + s d = c + u a₁ + v a₂.
struct Ray {
  Exact u, v, z, du, dv, dz;
  double facing_ratio;  ///< |n·d| / (|n| |d|)
};
[[nodiscard]] Ray along(const MovingKernel& kernel, double x, double y, Digits digits = Digits::fifty);

struct Fragment {
  bool hit = false;
  Exact t_begin, t_end, peak, y_begin, rate, z_begin, z_rate;
  double across = 0.0;  ///< distance of the line from the disc's centre
};
/// Tube ∩ segment ∩ {z ≥ near} for exact coordinates.
[[nodiscard]] Fragment intersect_tube(const RayCoordinates<double>& ray, double segment_begin,
                                      double segment_end, double near, double delta, double weight,
                                      Digits digits = Digits::fifty);

/// ∫ρ dτ over that fragment; 0 where there is none.
[[nodiscard]] Exact fragment_integral(const RayCoordinates<double>& ray, double segment_begin,
                                      double segment_end, double near, double delta, double weight,
                                      Digits digits = Digits::quad);

/// The line's state at time t, exactly.
struct State {
  double radius_minus_one;  ///< √(u² + v²) − 1
  double along, across;     ///< position along the line from the point nearest the centre, and its distance
  double z;
};
[[nodiscard]] State state_at(const RayCoordinates<double>& ray, double t_mid, double t,
                             Digits digits = Digits::fifty);

/// value(t) = z + rate (t − t_begin) of two lines; where they are equal. Requires different rates.
[[nodiscard]] Exact crossing(double z0, double rate0, double t0, double z1, double rate1, double t1,
                             Digits digits = Digits::fifty);

/// √(|QQᵀ| / |QQᵀ + r²I|) and the size of model section 5, for given tangent and radius r.
struct Filtered {
  Exact weight, size;
};
[[nodiscard]] Filtered filter(const Eigen::Vector3d& axis_u, const Eigen::Vector3d& axis_v,
                              const Eigen::Vector2d& tangent, double radius, Digits digits = Digits::fifty);

/// Spacing of T at x; of its smallest numbers below the normal ones.
template <class T>
[[nodiscard]] double ulp(double x) {
  constexpr int digits = std::numeric_limits<T>::digits;
  constexpr int lowest = std::numeric_limits<T>::min_exponent - digits;
  int exponent = 0;
  std::frexp(x, &exponent);
  return std::ldexp(1.0, x == 0.0 ? lowest : std::max(exponent - digits, lowest));
}

[[nodiscard]] inline double error(double value, Exact exact) {
  return std::abs((value - exact.high) - exact.low);
}

template <class T>
[[nodiscard]] double ulps(T value, Exact exact) {
  return error(static_cast<double>(value), exact) / ulp<T>(exact.high);
}

/// Whether the exact value rounds to a normal number of T.
template <class T>
[[nodiscard]] bool normal(Exact exact) {
  return std::abs(exact.high) >= double{std::numeric_limits<T>::min()} &&
         std::abs(exact.high) <= double{std::numeric_limits<T>::max()};
}

}  // namespace swept::oracle
