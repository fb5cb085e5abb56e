// What holds for every kernel and every ray, on random ones; a failure is reported in its simplest form.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/kernel/kernel_integral.h"
#include "splat/kernel/ray_kernel.h"
#include "splat/kernel/screen_bounds.h"
#include "tests/oracle/hard_kernels.h"
#include "tests/oracle/ray_bounds.h"
#include "tests/oracle/shrink.h"

namespace swept {
namespace {

using oracle::Random;

constexpr double delta = 3.0, near_depth = oracle::near_depth;

/// Center, velocity, axes and ray as one row of numbers.
std::vector<double> numbers_of(const oracle::KernelAndRay& input) {
  const MovingKernel& k = input.kernel;
  std::vector<double> numbers;
  for (int i = 0; i < 3; ++i) numbers.push_back(k.center[i]);
  for (int i = 0; i < 3; ++i) numbers.push_back(k.velocity[i]);
  for (int i = 0; i < 3; ++i) numbers.push_back(k.axis_u[i]);
  for (int i = 0; i < 3; ++i) numbers.push_back(k.axis_v[i]);
  numbers.push_back(input.x);
  numbers.push_back(input.y);
  return numbers;
}

oracle::KernelAndRay kernel_of(const std::vector<double>& numbers) {
  oracle::KernelAndRay input;
  for (int i = 0; i < 3; ++i) {
    input.kernel.center[i] = numbers[i];
    input.kernel.velocity[i] = numbers[3 + i];
    input.kernel.axis_u[i] = static_cast<float>(numbers[6 + i]);
    input.kernel.axis_v[i] = static_cast<float>(numbers[9 + i]);
  }
  input.kernel.facing.setZero();
  input.x = numbers[12];
  input.y = numbers[13];
  return input;
}

/// Holds `property` against `count` kernels of each hard case.
template <class Property>
void expect_always(Property property, int count) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    Random random(11);
    for (int i = 0; i < count; ++i) {
      const std::vector<double> input = numbers_of(hard.make(random));
      const auto fails = [&](const std::vector<double>& numbers) { return !property(kernel_of(numbers)); };
      if (!fails(input)) continue;
      std::ostringstream text;
      text.precision(17);
      for (const double number : oracle::shrink(input, fails)) text << number << ' ';
      ADD_FAILURE() << hard.name << ", simplest failing center, velocity, axes, ray: " << text.str();
      return;
    }
  }
}

bool fragment_of(const oracle::KernelAndRay& input, RayCoordinates<double>& ray, RayFragment<double>& f) {
  ray = KernelPlane<double>(input.kernel).along(input.x, input.y);
  return intersect_tube(ray, 0.0, 1.0, near_depth, delta, 1.0, f);
}

double integral_of(const RayFragment<double>& f, double from, double to) {
  return interval_integral(f.peak, to - from, f.y_begin + f.rate * (from - f.t_begin),
                           f.y_begin + f.rate * (to - f.t_begin));
}

/// By definition: ∫ exp(−δ(u² + v²)) dτ over the fragment, in 32 panels of four Gauss points.
double integral_by_definition(const RayCoordinates<double>& ray, const RayFragment<double>& f) {
  constexpr double place[2] = {0.3399810435848563, 0.8611363115940526},
                   weight[2] = {0.6521451548625461, 0.3478548451374538};
  double sum = 0.0;
  const double half = (f.t_end - f.t_begin) / 64.0;
  for (int panel = 0; panel < 32; ++panel)
    for (int point = 0; point < 2; ++point)
      for (const double sign : {-1.0, 1.0}) {
        const double t = f.t_begin + half * (2 * panel + 1 + sign * place[point]) - 0.5;
        const double u = ray.u + t * ray.du, v = ray.v + t * ray.dv;
        sum += weight[point] * half * std::exp(-delta * (u * u + v * v));
      }
  return sum;
}

/// What (u, v) are off by, times the greatest slope of exp(−δr²), √(2δ/e) < 1.5, over the duration; and 10⁻¹²
/// for quadrature: with the tube at most 2 long a panel is √δ/16 of y, and Gauss' remainder below
/// 0.11⁸ · 8!⁻¹ · (4!⁴ / 8!²) · max H₈ ≈ 10⁻¹³.
TEST(KernelProperty, TheClosedFormIsTheIntegral) {
  expect_always(
      [](const oracle::KernelAndRay& input) {
        RayCoordinates<double> ray;
        RayFragment<double> f;
        if (!fragment_of(input, ray, f)) return true;
        const double duration = f.t_end - f.t_begin;
        const double w = std::hypot(ray.u, ray.v), s = std::hypot(ray.du, ray.dv);
        const double moved = 0x1p-53 * 48 * (1 + w + s);
        const double bound = duration * (std::min(1.0, 1.5 * std::sqrt(delta) * moved) + 1e-12);
        return std::abs(integral_of(f, f.t_begin, f.t_end) - integral_by_definition(ray, f)) <= bound;
      },
      2000);
}

/// 5 ulp for either side and their ends' rounding, whose y is off by ε (|y| + 2 rate).
TEST(KernelProperty, PartsOfAnExposureSumToTheWhole) {
  expect_always(
      [](const oracle::KernelAndRay& input) {
        RayCoordinates<double> ray;
        RayFragment<double> f;
        if (!fragment_of(input, ray, f)) return true;
        const double cut = f.t_begin + 0.3 * (f.t_end - f.t_begin);
        if (!(f.t_begin < cut && cut < f.t_end)) return true;
        const double whole = integral_of(f, f.t_begin, f.t_end);
        const double parts = integral_of(f, f.t_begin, cut) + integral_of(f, cut, f.t_end);
        const double duration = f.t_end - f.t_begin;
        const double y_error = 0x1p-53 * (std::abs(f.y_begin) + 3 * f.rate * duration + 2);
        return std::abs(parts - whole) <=
               f.peak * duration * (12 * 0x1p-53 + 4 * 0.86 * y_error) + 12 * 0x1p-52 * whole;
      },
      2000);
}

TEST(KernelProperty, AFragmentLiesInItsBounds) {
  expect_always(
      [](const oracle::KernelAndRay& input) {
        RayCoordinates<double> ray;
        RayFragment<double> f;
        if (!fragment_of(input, ray, f)) return true;
        const Projection film{oracle::focal_px, 0.0, 0.0};
        Octagon octagon;
        if (!screen_bounds(input.kernel, film, near_depth, octagon)) return false;
        const double x = oracle::focal_px * input.x, y = oracle::focal_px * input.y;
        double x_min, x_max;
        return octagon.span(y, y, x_min, x_max) && x_min <= x && x <= x_max && octagon.overlaps({x, x, y, y});
      },
      2000);
}

TEST(KernelProperty, DepthsAreAtOrBeyondTheNearPlane) {
  expect_always(
      [](const oracle::KernelAndRay& input) {
        RayCoordinates<double> ray;
        RayFragment<double> f;
        if (!fragment_of(input, ray, f)) return true;
        const double bound = 8 * 0x1p-53 * (std::abs(ray.z) + near_depth + std::abs(ray.dz));
        return f.z_begin >= near_depth - bound &&
               f.z_begin + f.z_rate * (f.t_end - f.t_begin) >= near_depth - 2 * bound;
      },
      2000);
}

/// The shrinker itself, on a property that is false for all kernels that move right by more than ¼.
TEST(KernelProperty, AFailureIsMadeSimple) {
  Random random(12);
  std::vector<double> input = numbers_of(oracle::hard_cases()[0].make(random));
  input[3] = 0.7390851332151607;
  const auto fails = [](const std::vector<double>& numbers) { return numbers[3] > 0.25; };
  const std::vector<double> simple = oracle::shrink(input, fails);
  for (std::size_t i = 0; i < simple.size(); ++i) EXPECT_EQ(simple[i], i == 3 ? 1.0 : 0.0) << i;
}

}  // namespace
}  // namespace swept
