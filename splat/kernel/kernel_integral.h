// Integrals of a moving kernel over time, stably.
//
// Source: model section 3; Heinzle et al. 2010, Eq. 18 to 20. Written as Heinzle does, the integral is 0/0
// for a kernel that stands still and a difference of nearly equal numbers in the tails. Here it is the
// interval's length times the mean of exp(−y²) over [y_begin, y_end], y being the kernel's position along its
// line. No branch subtracts two integrals:
//
//   short intervals    exp(−m²) times a Taylor series about the middle m
//   astride the peak   a sum of two erf, divided by the span
//   to one side of it  exp(−a²) times a Gauss-Legendre sum of exp(−t(2a + t)), a being the nearer end
//
// exp(−m²) would lose m² ulp to the rounding of m·m, so squares are carried with their rounding errors.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "splat/export.h"

namespace SWEPT_API swept {

/// The mean of exp(−y²) over [m − s/2, m + s/2] as exp(−m²) · Σ H₂ₙ(m) s²ⁿ / (4ⁿ (2n+1)!), Hₖ being the
/// Hermite polynomials.
template <class T>
struct GaussianSeries;

template <>
struct GaussianSeries<float> {
  /// Terms n ≤ 4. Where `holds`, the first one dropped is below 2⁻²³: it is at most (m s)¹⁰/11! +
  /// s¹⁰/(4⁵·5!·11).
  /// `V`: float, or a vector of floats.
  template <class V>
  [[nodiscard, gnu::always_inline]] static inline V factor(const V& middle, const V& span) {
    const V m2 = 4.0f * middle * middle;
    const V h2 = m2 - 2.0f;
    const V h4 = (m2 - 12.0f) * m2 + 12.0f;
    const V h6 = ((m2 - 30.0f) * m2 + 180.0f) * m2 - 120.0f;
    const V h8 = (((m2 - 56.0f) * m2 + 840.0f) * m2 - 3360.0f) * m2 + 1680.0f;
    const V s2 = span * span;
    return 1.0f + s2 * (h2 * (1.0f / 24.0f) +
                        s2 * (h4 * (1.0f / 1920.0f) +
                              s2 * (h6 * (1.0f / 322560.0f) + s2 * (h8 * (1.0f / 92897280.0f)))));
  }
  [[nodiscard]] static double excess(float middle, float span) { return double{factor(middle, span)} - 1.0; }
  [[nodiscard]] static bool holds(float middle, float span) {
    return span * (1.0f + 0.8f * std::abs(middle)) <= 0.8f;
  }
};

template <>
struct GaussianSeries<double> {
  [[nodiscard]] static double factor(double middle, double span) { return 1.0 + excess(middle, span); }
  /// factor − 1, which is at most 0.2. Terms n ≤ 9, by the recurrence Hₖ₊₁ = 2m Hₖ − 2k Hₖ₋₁, added up from
  /// the smallest. Where `holds`, the first one dropped is below 2⁻⁵⁶.
  [[nodiscard]] static double excess(double middle, double span) {
    constexpr int terms = 9;
    double term[terms];
    double previous = 1.0, current = 2.0 * middle;  // H₀, H₁
    double scale = 1.0;
    for (int n = 1; n <= terms; ++n) {
      const int k = 2 * n - 1;
      previous = 2.0 * middle * current - 2.0 * k * previous;
      scale *= span * span / (4.0 * (k + 1) * (k + 2));
      term[n - 1] = previous * scale;
      current = 2.0 * middle * previous - 2.0 * (k + 1) * current;
    }
    double sum = 0.0;
    for (int n = terms; n-- > 0;) sum += term[n];
    return sum;
  }
  [[nodiscard]] static bool holds(double middle, double span) {
    return span * (1.0 + 0.8 * std::abs(middle)) <= 0.8;
  }
};

/// Gauss-Legendre sum on [0, 1], places and weights, and the exponent at which exp is cut off. With `cut_off`
/// as the largest exponent the sum is off by less than 2⁻⁵⁶ (double) and 2⁻²⁸ (float), relative; by another
/// 0.14 · 2⁻⁵³ for the rounding of places and weights.
template <class T>
struct TailQuadrature;

template <>
struct TailQuadrature<float> {
  static constexpr double cut_off = 20.0;
  static constexpr int nodes = 12;
  static constexpr double node[nodes][2] = {
      {0.009219682876640375, 0.023587668193255914}, {0.04794137181476257, 0.05346966299765921},
      {0.11504866290284765, 0.08003916427167311},   {0.2063410228566913, 0.10158371336153296},
      {0.3160842505009099, 0.1167462682691774},     {0.43738329574426554, 0.12457352290670139},
      {0.5626167042557345, 0.12457352290670139},    {0.6839157494990901, 0.1167462682691774},
      {0.7936589771433087, 0.10158371336153296},    {0.8849513370971523, 0.08003916427167311},
      {0.9520586281852375, 0.05346966299765921},    {0.9907803171233597, 0.023587668193255914}};
};

template <>
struct TailQuadrature<double> {
  static constexpr double cut_off = 40.0;
  static constexpr int nodes = 24;
  static constexpr double node[nodes][2] = {
      {0.00240639000148932, 0.0061706148999936},    {0.012635722014345251, 0.014265694314466832},
      {0.030862723998633622, 0.022138719408709904}, {0.056792236497799485, 0.02964929245771839},
      {0.08999900701304854, 0.03667324070554015},   {0.12993790421072282, 0.04309508076597664},
      {0.17595317403151223, 0.04880932605205694},   {0.22728926430558022, 0.05372213505798282},
      {0.2831032461869774, 0.0577528340268628},     {0.3424786601519183, 0.060835236463901696},
      {0.40444056626319186, 0.06291872817341415},   {0.4679715535686972, 0.06396909767337608},
      {0.5320284464313028, 0.06396909767337608},    {0.5955594337368082, 0.06291872817341415},
      {0.6575213398480817, 0.060835236463901696},   {0.7168967538130225, 0.0577528340268628},
      {0.7727107356944197, 0.05372213505798282},    {0.8240468259684878, 0.04880932605205694},
      {0.8700620957892772, 0.04309508076597664},    {0.9100009929869515, 0.03667324070554015},
      {0.9432077635022005, 0.02964929245771839},    {0.9691372760013663, 0.022138719408709904},
      {0.9873642779856547, 0.014265694314466832},   {0.9975936099985107, 0.0061706148999936}};
};

/// Which formula mean_gaussian takes.
enum class GaussianBranch { underflow, series, astride, one_sided };

namespace detail {

/// A number and what its rounding left over.
struct Rounded {
  double value, low;
};

inline Rounded add(double a, double b) {
  const double sum = a + b, of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// exp(−(y + y_low)²) · factor for y ≥ 0, |y_low| ≤ ulp(y). One rounding of exp and one of the product,
/// whatever y is.
inline double exp_minus_square(double y, double y_low, Rounded factor) {
  const double square = y * y;
  double low = std::fma(y, y, -square) + 2.0 * y * y_low;
  double scale = 1.0;
  double exponential;
  if (square < 690.0) {
    exponential = std::exp(-square);
  } else {
    // exp would be subnormal, and short of digits, while the product with a factor above 1 is not. 46 ln 2 in
    // two parts; the difference from the first, a multiple of 2⁻⁴³, is exact.
    exponential = std::exp(-(square - 0x1.fe2804e87b34p+4));
    scale = 0x1p-46;
    low -= 2.7934158730298086e-14;
  }
  return std::fma(exponential, factor.value, exponential * (factor.low - factor.value * low)) * scale;
}

/// For y_begin ≤ 0 ≤ y_end: √π/2 · (erf(y_end) + erf(−y_begin)) / (y_end − y_begin).
template <class T>
double mean_astride(double y_begin, double y_end) {
  const Rounded sum = add(std::erf(static_cast<T>(y_end)), std::erf(static_cast<T>(-y_begin)));
  const Rounded half = add(0.5 * y_end, -0.5 * y_begin);  // the span itself may overflow
  constexpr double k = std::numbers::inv_sqrtpi, k_low = 7.66772980658294e-18;
  const double divisor = half.value * k;
  const double divisor_low = std::fma(half.value, k, -divisor) + (half.value * k_low + half.low * k);
  const double quotient = sum.value / divisor;
  return 0.25 * (quotient + quotient * (sum.low / sum.value - divisor_low / divisor));
}

/// For 0 < y_begin: the mean of exp(−y²) divided by exp(−y_begin²). All terms are positive.
template <class T>
Rounded mean_from_begin(double y_begin, double y_end) {
  using Quadrature = TailQuadrature<T>;
  const Rounded span = add(y_end, -y_begin);
  // Where t(2a + t) reaches the cut-off; the integral beyond is below exp(−cut_off) of the whole.
  const double reach = Quadrature::cut_off / (y_begin + std::sqrt(y_begin * y_begin + Quadrature::cut_off));
  const double length = std::min(span.value, reach);
  const double length_low = length < span.value ? 0.0 : span.low;
  Rounded sum{0.0, 0.0};
  for (int i = Quadrature::nodes; i-- > 0;) {
    const auto [place, weight] = Quadrature::node[i];
    const double t = length * place;
    if constexpr (sizeof(T) < sizeof(double)) {
      // A float's result has no use for what rounding in double leaves over.
      sum.value += weight * std::exp(static_cast<T>(-t * (2.0 * y_begin + t)));
    } else {
      const double t_low = std::fma(length, place, -t) + length_low * place;
      const Rounded factor = add(2.0 * y_begin, t);
      const double exponent = t * factor.value;
      const double exponent_low =
          std::fma(t, factor.value, -exponent) + t * factor.low + t_low * (factor.value + t);
      const double exponential = std::exp(-exponent), term = weight * exponential;
      const Rounded next = add(sum.value, term);
      sum = {next.value, sum.low + next.low + (std::fma(weight, exponential, -term) - term * exponent_low)};
    }
  }
  if (!(length < span.value)) return sum;
  const double integral = sum.value * length;
  const double mean = integral / span.value;
  const double rest = std::fma(-mean, span.value, integral) + std::fma(sum.value, length, -integral);
  return {mean, (rest + sum.low * length - mean * span.low) / span.value};
}

/// To T's precision, for ends in double whatever T is.
template <class T>
double mean_gaussian(double a, double b, GaussianBranch& branch) {
  if (a + b < 0.0) {  // b ≥ |a| from here on
    const double mirrored = -a;
    a = -b;
    b = mirrored;
  }
  if (a > 40.0) {
    branch = GaussianBranch::underflow;
    return 0.0;
  }
  const double span = b - a;
  const Rounded sum = add(b, a);
  const double middle = 0.5 * sum.value;
  if (GaussianSeries<T>::holds(static_cast<T>(middle), static_cast<T>(std::min(span, 1.0)))) {
    branch = GaussianBranch::series;
    const double excess = GaussianSeries<T>::excess(static_cast<T>(middle), static_cast<T>(span));
    return exp_minus_square(middle, 0.5 * sum.low, add(1.0, excess));
  }
  if (a <= 0.0) {
    branch = GaussianBranch::astride;
    return mean_astride<T>(a, b);
  }
  branch = GaussianBranch::one_sided;
  return exp_minus_square(a, 0.0, mean_from_begin<T>(a, b));
}

}  // namespace detail

/// Mean of exp(−y²) over [y_begin, y_end], y_begin ≤ y_end, both finite; exp(−y²) itself if they are equal.
/// In [0, 1]; 0 only where it underflows. mean(a, b) and mean(−b, −a) are the same bits.
///
/// Wherever the result is a normal number it is within 4 ulp (double) or 3 ulp (float) of the exact mean for
/// the given ends, if exp is within 0.6 ulp and erf within 1 ulp as glibc's are. What double loses, in units
/// of 2⁻⁵³, an ulp being one to two of them:
///
/// - series: 1.2 for exp, 1 for the product, 1.4 for the excess over 1, which is below 0.175 and whose terms
///   take at most 8 roundings each.
/// - astride: 2 for erf, 1 for the quotient, 1 for the result. The rest is carried to twice the digits.
/// - one-sided: 1.2 for exp, 1 for the product, and for the sum 1.2 for exp, if all terms' conspired, and 0.3
///   for places, weights and what the quadrature leaves over. The rest is carried to twice the digits.
///
/// None of it grows with the span or towards a switch. Float is computed in double but for erf, the one-sided
/// exp and the series' excess: half an ulp for the result and one or two for those.
template <class T>
[[nodiscard]] T mean_gaussian(T y_begin, T y_end) {
  GaussianBranch branch;
  return static_cast<T>(detail::mean_gaussian<T>(y_begin, y_end, branch));
}

/// The same with more digits in the ends than T has: within 4 ulp of T for them.
template <class T>
[[nodiscard]] T mean_gaussian_as(double y_begin, double y_end) {
  GaussianBranch branch;
  return static_cast<T>(detail::mean_gaussian<T>(y_begin, y_end, branch));
}

/// The formula that mean_gaussian takes for these ends, for tables and tests.
template <class T>
[[nodiscard]] GaussianBranch gaussian_branch(T y_begin, T y_end) {
  GaussianBranch branch;
  (void)detail::mean_gaussian<T>(y_begin, y_end, branch);
  return branch;
}

/// ∫ρ dτ = peak · duration · mean of exp(−y²) over [y_begin, y_end]. One or two roundings more than the mean.
template <class T>
[[nodiscard]] T interval_integral(T peak, T duration, T y_begin, T y_end) {
  return peak * (duration * mean_gaussian(y_begin, y_end));
}

/// Where between y_begin and y_end exp(−y²) has its weight: ∫(y − m) exp(−y²) dy / (s ∫exp(−y²) dy) in
/// [−½, ½], m being the middle and s the span. Zero if the ends are equal; the nearer end where exp(−y²)
/// underflows. Else within 7·10⁻⁵, where a series in x = m s, Langevin's function, and in s² takes over.
inline double gaussian_centroid(double y_begin, double y_end) {
  const double span = y_end - y_begin, middle = 0.5 * (y_begin + y_end), x = middle * span;
  const double x2 = x * x, s2 = span * span;
  if (x2 <= 1.0 && span <= 0.5)
    return x * (-1.0 / 6.0) *
           (1.0 - (x2 + s2) * (1.0 / 15.0) + ((2.0 * x2 + 4.0 * s2) * x2 + 0.5 * s2 * s2) * (1.0 / 315.0) -
            x2 * x2 * x2 * (1.0 / 1575.0));
  const double mean = mean_gaussian(y_begin, y_end);
  if (!(mean >= std::numeric_limits<double>::min())) return middle > 0.0 ? -0.5 : 0.5;
  const double ends = std::exp(-y_begin * y_begin) - std::exp(-y_end * y_end);
  return std::clamp((0.5 * ends / span - middle * mean) / (span * mean), -0.5, 0.5);
}

}  // namespace swept
