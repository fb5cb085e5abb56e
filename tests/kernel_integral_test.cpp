// The mean of exp(−y²) against a 50-digit oracle, over every branch and across the switches between them.
#include "splat/kernel/kernel_integral.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/oracle/naive.h"
#include "tests/oracle/oracle.h"

namespace swept {
namespace {

template <class T>
constexpr T farthest = sizeof(T) == 4 ? T(9.3) : T(26.6);  ///< beyond it exp(−y²) is not a normal number

/// Ends of an interval, from every regime: spans from 2⁻⁶⁰ to 2⁹, near the switches, in the tails, astride.
template <class T>
std::pair<T, T> ends(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double far = farthest<T>;
  double a = far * (2.0 * unit(random) - 1.0), b = a;
  switch (random() % 6) {
    case 0:
      b += std::exp2(-60.0 + 69.0 * unit(random));
      break;
    case 1:  // about the series' switch
      b += 0.8 / (1.0 + 0.8 * std::abs(a)) * (0.5 + unit(random));
      break;
    case 2:
      a = 0.5 * unit(random);
      b = a + 2.0 * unit(random);
      break;
    case 3:
      a = -6.0 * unit(random);
      b = 6.0 * unit(random);
      break;
    case 4:
      a = std::exp2(-30.0 + 34.0 * unit(random));
      b = a * (1.0 + 3.0 * unit(random));
      break;
    default:  // far ends on both sides or on one
      b = std::exp2(1000.0 * unit(random) / (sizeof(T) == 4 ? 8.0 : 1.0));
      a = random() % 2 ? a : -b * unit(random);
  }
  T first = static_cast<T>(a), second = static_cast<T>(b);
  if (random() % 2) std::swap(first = -first, second = -second);
  return {std::min(first, second), std::max(first, second)};
}

struct Worst {
  double ulps = 0.0;
  double a = 0.0, b = 0.0;
  int normal = 0;
};

template <class T, class Mean>
Worst worst_of(Mean mean, int points, unsigned seed) {
  std::mt19937_64 random(seed);
  Worst worst;
  for (int i = 0; i < points; ++i) {
    const auto [a, b] = ends<T>(random);
    const oracle::Exact exact = oracle::mean_gaussian(a, b, oracle::Digits::quad);
    if (!oracle::normal<T>(exact)) continue;
    ++worst.normal;
    const double off = oracle::ulps(mean(a, b), exact);
    if (!(off <= worst.ulps)) worst = {off, a, b, worst.normal};
  }
  return worst;
}

TEST(KernelIntegral, ClosedFormAndQuadratureAgreeTo40Digits) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 100; ++i) {
    const double a = 26.0 * (2.0 * unit(random) - 1.0), b = a + std::exp2(-40.0 + 50.0 * unit(random));
    EXPECT_LT(oracle::quadrature_disagreement(a, b), 1e-40) << a << " " << b;
  }
}

/// The quick oracle is good for 2⁻⁴⁰ of an ulp.
TEST(KernelIntegral, QuadPrecisionSufficesForTheOracle) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 300; ++i) {
    const auto [a, b] = ends<double>(random);
    const oracle::Exact fifty = oracle::mean_gaussian(a, b),
                        quad = oracle::mean_gaussian(a, b, oracle::Digits::quad);
    if (!oracle::normal<double>(fifty)) continue;
    EXPECT_EQ(fifty.high, quad.high);
    EXPECT_LE(std::abs(fifty.low - quad.low), 0x1p-93 * fifty.high) << a << " " << b;
  }
}

TEST(KernelIntegral, MeanIsWithin4UlpInDouble) {
  const Worst worst = worst_of<double>([](double a, double b) { return mean_gaussian(a, b); }, 60000, 3);
  EXPECT_GT(worst.normal, 40000);
  EXPECT_LE(worst.ulps, 4.0) << worst.a << " " << worst.b;
}

TEST(KernelIntegral, MeanIsWithin3UlpInFloat) {
  const Worst worst = worst_of<float>([](float a, float b) { return mean_gaussian(a, b); }, 60000, 4);
  EXPECT_GT(worst.normal, 40000);
  EXPECT_LE(worst.ulps, 3.0) << worst.a << " " << worst.b;
}

TEST(KernelIntegral, TheCheckCatchesADifferenceOfErf) {
  EXPECT_FALSE(
      worst_of<double>([](double a, double b) { return naive::mean_gaussian(a, b); }, 1000, 3).ulps <= 1e6);
  EXPECT_FALSE(worst_of<float>([](float a, float b) { return naive::mean_gaussian(a, b); }, 1000, 4).ulps <=
               1e6);
}

/// And a formula that is right but for the rounding of y².
TEST(KernelIntegral, TheCheckCatchesAPlainSquare) {
  const auto plain = [](double a, double b) {
    const double middle = 0.5 * (a + b);
    return GaussianSeries<double>::holds(middle, b - a)
               ? std::exp(-middle * middle) * GaussianSeries<double>::factor(middle, b - a)
               : mean_gaussian(a, b);
  };
  EXPECT_GT(worst_of<double>(plain, 20000, 3).ulps, 50.0);
}

/// From a span on the series' side of its switch to one beyond, by bisection down to neighbouring numbers:
/// both sides keep their stated error there, so the step is at most the two together.
template <class T>
void step_across_switches(double bound) {
  for (T start : {T(-9), T(-4), T(-0.9), T(-0.4), T(-0.1), T(0), T(0.1), T(0.5), T(1), T(3), T(9)}) {
    T low = start, high = start + T(4);
    ASSERT_EQ(gaussian_branch(start, low), GaussianBranch::series);
    ASSERT_NE(gaussian_branch(start, high), GaussianBranch::series);
    while (std::nextafter(low, high) < high) {
      const T middle = low + (high - low) / 2;
      (gaussian_branch(start, middle) == GaussianBranch::series ? low : high) = middle;
    }
    for (T end : {low, high})
      EXPECT_LE(oracle::ulps(mean_gaussian(start, end), oracle::mean_gaussian(start, end)), bound)
          << double{start} << " " << double{end};
  }
  // Astride the peak or just beside it, the nearer end being zero or the smallest number.
  for (T end : {T(0.9), T(2), T(100)}) {
    const T begin = std::numeric_limits<T>::denorm_min();
    ASSERT_EQ(gaussian_branch(T(0), end), GaussianBranch::astride);
    ASSERT_EQ(gaussian_branch(begin, end), GaussianBranch::one_sided);
    for (T first : {-begin, T(0), begin})
      EXPECT_LE(oracle::ulps(mean_gaussian(first, end), oracle::mean_gaussian(first, end)), bound);
  }
}

TEST(KernelIntegral, IsContinuousAcrossItsSwitches) {
  step_across_switches<double>(4.0);
  step_across_switches<float>(3.0);
}

/// Within the branches: where exp's argument is shifted, and where the tail is cut off.
TEST(KernelIntegral, IsContinuousWithinItsBranches) {
  const double shifted = std::sqrt(690.0);
  for (double y = shifted - 1e-13; y < shifted + 1e-13; y = std::nextafter(y, 100.0))
    EXPECT_LE(oracle::ulps(mean_gaussian(y, y), oracle::mean_gaussian(y, y)), 4.0) << y;
  const double cut_off = TailQuadrature<double>::cut_off;
  for (const double a : {1e-9, 0.1, 0.5, 2.0, 7.0, 20.0, 26.0}) {
    const double reach = cut_off / (a + std::sqrt(a * a + cut_off));
    for (int i = -20; i <= 20; ++i) {
      const double b = (a + reach) * (1.0 + i * 0x1p-52);
      EXPECT_LE(oracle::ulps(mean_gaussian(a, b), oracle::mean_gaussian(a, b)), 4.0) << a << " " << b;
    }
  }
}

/// From a span of 10⁻⁹ on, for the oracle's difference to keep its digits, and on either side of the switch.
TEST(KernelIntegral, CentroidIsWhereTheWeightIs) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double span = std::exp2(-30.0 + 33.0 * unit(random));
    double middle = 12.0 * (2.0 * unit(random) - 1.0);
    if (i % 3 == 0) middle = (0.99 + 0.02 * unit(random)) / span;
    const double a = middle - 0.5 * span, b = middle + 0.5 * span;
    if (!(std::max(std::abs(a), std::abs(b)) <= 25.0)) continue;
    const double centroid = gaussian_centroid(a, b);
    worst = std::max(worst, oracle::error(centroid, oracle::gaussian_centroid(a, b)));
    ASSERT_EQ(centroid, -gaussian_centroid(-b, -a)) << a << " " << b;
  }
  EXPECT_LE(worst, 7e-5);
  EXPECT_EQ(gaussian_centroid(2.0, 2.0), 0.0);
  for (const double far : {30.0, 1e100, 1e300}) {
    EXPECT_EQ(gaussian_centroid(far, 2.0 * far), -0.5);
    EXPECT_EQ(gaussian_centroid(-2.0 * far, -far), 0.5);
    EXPECT_LE(std::abs(gaussian_centroid(-far, far)), 0.5);
  }
}

TEST(KernelIntegral, AnInstantIsTheGaussianItself) {
  for (double y = -26.5; y <= 26.5; y += 0.37) {
    EXPECT_LE(oracle::ulps(mean_gaussian(y, y), oracle::mean_gaussian(y, y)), 4.0) << y;
    const float f = static_cast<float>(y);
    if (std::abs(f) > farthest<float>) continue;
    EXPECT_LE(oracle::ulps(mean_gaussian(f, f), oracle::mean_gaussian(f, f)), 3.0) << y;
  }
  EXPECT_EQ(mean_gaussian(0.0, 0.0), 1.0);
}

TEST(KernelIntegral, ReversedTimeGivesTheSameBits) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 20000; ++i) {
    const auto [a, b] = ends<double>(random);
    EXPECT_EQ(mean_gaussian(a, b), mean_gaussian(-b, -a)) << a << " " << b;
    const auto [c, d] = ends<float>(random);
    EXPECT_EQ(mean_gaussian(c, d), mean_gaussian(-d, -c)) << c << " " << d;
  }
}

/// Ends on a grid, so that durations are exact. Each side is within 4 ulp for the mean and half an ulp for
/// each of two products; the sum of the parts rounds once more.
TEST(KernelIntegral, PartsSumToTheWhole) {
  std::mt19937_64 random(6);
  std::uniform_int_distribution<int> grid(-8 * 65536, 8 * 65536);
  for (int i = 0; i < 20000; ++i) {
    double t[3] = {};
    for (double& time : t) time = grid(random) / 65536.0;
    std::sort(t, t + 3);
    const auto part = [](double a, double b) { return interval_integral(0.75, b - a, a, b); };
    const double parts = part(t[0], t[1]) + part(t[1], t[2]);
    const double whole = part(t[0], t[2]);
    const double ulp = oracle::ulp<double>(std::max(parts, whole));
    EXPECT_LE(std::abs(parts - whole), (2 * 5.0 + 0.5) * ulp) << t[0] << " " << t[1] << " " << t[2];
  }
}

template <class T>
void extremes() {
  std::vector<T> values;
  for (int exponent = std::numeric_limits<T>::min_exponent - std::numeric_limits<T>::digits;
       exponent < std::numeric_limits<T>::max_exponent; exponent += 5)
    for (T mantissa : {T(1), T(1.7)}) values.push_back(std::ldexp(mantissa, exponent));
  for (T value : {T(0), std::numeric_limits<T>::denorm_min(), std::numeric_limits<T>::min(),
                  std::numeric_limits<T>::max()})
    values.push_back(value);
  const std::size_t positive = values.size();
  for (std::size_t i = 0; i < positive; ++i) values.push_back(-values[i]);
  std::sort(values.begin(), values.end());
  for (std::size_t i = 0; i < values.size(); ++i)
    for (std::size_t j = i; j < values.size(); ++j) {
      const T mean = mean_gaussian(values[i], values[j]);
      ASSERT_TRUE(mean >= T(0) && mean <= T(1)) << double{values[i]} << " " << double{values[j]};
      const T one = T(1);
      ASSERT_LE(interval_integral(one, one, values[i], values[j]), one);
    }
}

TEST(KernelIntegral, IsBetweenZeroAndOneForAllFiniteEnds) {
  extremes<double>();
  extremes<float>();
}

}  // namespace
}  // namespace swept
