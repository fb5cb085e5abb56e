// A kernel along a ray against a 50-digit oracle: coordinates, tube, depth and Gaussian within the bounds
// that ray_kernel.h states, over the hard cases of model section 10.
#include "splat/kernel/ray_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/SVD>

#include "splat/kernel/kernel_integral.h"
#include "tests/oracle/hard_kernels.h"
#include "tests/oracle/naive.h"
#include "tests/oracle/oracle.h"
#include "tests/oracle/ray_bounds.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using oracle::uniform;

constexpr double unit_roundoff = 0x1p-53;

template <class T>
void expect_coordinates_within_bounds() {
  constexpr double unit = std::numeric_limits<T>::epsilon() / 2;
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    Random random(1);
    double worst = 0.0;
    int checked = 0;
    for (int i = 0; i < 400; ++i) {
      const auto [kernel, exact_x, exact_y] = hard.make(random);
      const T x = static_cast<T>(exact_x), y = static_cast<T>(exact_y);
      const RayCoordinates<T> c = KernelPlane<T>(kernel).along(x, y);
      const double ratio = oracle::coordinate_error(kernel, x, y, {c.u, c.v, c.z, c.du, c.dv, c.dz}, unit);
      if (std::isnan(ratio)) continue;  // in the plane
      worst = std::max(worst, ratio);
      ++checked;
    }
    EXPECT_LE(worst, 1.0) << hard.name;
    if (hard.name == "an axis of length zero" || hard.name == "parallel axes") continue;
    EXPECT_GT(checked, 390) << hard.name;
  }
}

TEST(KernelPlane, CoordinatesKeepTheirBoundsInDouble) { expect_coordinates_within_bounds<double>(); }
TEST(KernelPlane, CoordinatesKeepTheirBoundsInFloat) { expect_coordinates_within_bounds<float>(); }

/// Coordinates are taken from the ray through the centre unless that lies too far beside the eye. On either
/// side of that switch they keep their bounds, so they differ by no more than the two together.
TEST(KernelPlane, TheRayItStartsFromDoesNotShow) {
  Random random(9);
  for (int i = 0; i < 50; ++i) {
    MovingKernel kernel = oracle::hard_cases()[0].make(random).kernel;
    kernel.center = {3.0, uniform(random, -2.0, 2.0), 0.0};
    for (int step = -5; step <= 5; ++step) {
      kernel.center.z() = 3.0 * 0x1p-20 * (1.0 + step * 0x1p-52);
      const double x = uniform(random, -1.0, 1.0), y = uniform(random, -1.0, 1.0);
      EXPECT_LE(oracle::coordinate_error(kernel, x, y, KernelPlane<double>(kernel).along(x, y)), 1.0);
    }
  }
}

/// The inverse of [a₁ a₂ m c] (Heinzle 2010, Eq. 15 to 17) gives the same coordinates where it exists.
/// Computed by cofactors, it is off by up to 32 ε κ of its own norm, which the coordinates inherit to first
/// order.
TEST(KernelPlane, EqualsTheInverseWhereThatIsRegular) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    if (!hard.invertible || hard.name == "enormous axes") continue;
    Random random(2);
    int checked = 0;
    for (int i = 0; i < 400; ++i) {
      const auto [kernel, x, y] = hard.make(random);
      Eigen::Matrix4d frame = Eigen::Matrix4d::Identity();
      frame.topLeftCorner<3, 1>() = kernel.axis_u.cast<double>();
      frame.block<3, 1>(0, 1) = kernel.axis_v.cast<double>();
      frame.block<3, 1>(0, 2) = kernel.velocity;
      frame.block<3, 1>(0, 3) = kernel.center;
      const auto values = Eigen::JacobiSVD<Eigen::Matrix4d>(frame).singularValues();
      const double inverse_error = 32.0 * unit_roundoff * values[0] / values[3] / values[3];
      const Eigen::Vector4d ray = frame.inverse() * Eigen::Vector4d(x, y, 1.0, 0.0);
      const Eigen::Vector4d eye = frame.inverse().col(3);
      const double ray_error = inverse_error * std::hypot(x, y, 1.0);
      if (!(ray_error < 0.01 * std::abs(ray.z()))) continue;
      ++checked;
      const RayCoordinates<double> theirs = naive::along(kernel, x, y);
      const RayCoordinates<double> ours = KernelPlane<double>(kernel).along(x, y);
      const oracle::CoordinateBounds own =
          oracle::coordinate_bounds(kernel, x, y, oracle::along(kernel, x, y));
      // Slack of 1.1 for what is not first order, and the quotients' own roundings.
      const double z_error = 1.1 * (inverse_error + std::abs(theirs.z) * ray_error) / std::abs(ray.z()) +
                             4 * unit_roundoff * std::abs(theirs.z) + own.z;
      EXPECT_LE(std::abs(ours.z - theirs.z), z_error) << hard.name;
      const double size =
          eye.head<2>().cwiseAbs().maxCoeff() + std::abs(theirs.z) * ray.head<2>().cwiseAbs().maxCoeff();
      const double uv_error = inverse_error + std::abs(theirs.z) * ray_error +
                              z_error * ray.head<2>().cwiseAbs().maxCoeff() + 4 * unit_roundoff * size;
      EXPECT_LE(std::abs(ours.u - theirs.u), uv_error + own.u) << hard.name;
      EXPECT_LE(std::abs(ours.v - theirs.v), uv_error + own.v) << hard.name;
    }
    EXPECT_GT(checked, 50) << hard.name;
  }
}

/// Where motion lies in the plane there is no inverse, and what it gives fails the bounds.
TEST(KernelPlane, TheCheckCatchesTheInverse) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    if (hard.name != "motion in the disc's plane") continue;
    Random random(1);
    double worst = 0.0;
    for (int i = 0; i < 100; ++i) {
      const auto [kernel, x, y] = hard.make(random);
      const double ratio = oracle::coordinate_error(kernel, x, y, naive::along(kernel, x, y));
      worst = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : std::max(worst, ratio);
    }
    EXPECT_GT(worst, 1e3);
  }
}

TEST(KernelPlane, ScalingByAPowerOfTwoChangesNoBits) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    Random random(3);
    for (const int power : {1, -1, 11, -20, 30}) {
      const auto [kernel, x, y] = hard.make(random);
      if (hard.name == "enormous axes" && kernel.axis_u.norm() > 1e25f) continue;  // beyond a float
      MovingKernel scaled = kernel;
      const double factor = std::ldexp(1.0, power);
      scaled.center *= factor;
      scaled.velocity *= factor;
      scaled.axis_u *= static_cast<float>(factor);
      scaled.axis_v *= static_cast<float>(factor);
      const RayCoordinates<double> a = KernelPlane<double>(kernel).along(x, y);
      const RayCoordinates<double> b = KernelPlane<double>(scaled).along(x, y);
      const auto same = [](double p, double q) { return p == q || (std::isnan(p) && std::isnan(q)); };
      EXPECT_TRUE(same(a.u, b.u) && same(a.v, b.v) && same(a.du, b.du) && same(a.dv, b.dv)) << hard.name;
      EXPECT_TRUE(same(a.z * factor, b.z) && same(a.dz * factor, b.dz)) << hard.name;
      RayFragment<double> f, g;
      const bool hit = intersect_tube(a, 0.0, 1.0, oracle::near_depth, 3.0, 1.0, f);
      ASSERT_EQ(hit, intersect_tube(b, 0.0, 1.0, oracle::near_depth * factor, 3.0, 1.0, g)) << hard.name;
      if (!hit) continue;
      EXPECT_TRUE(f.t_begin == g.t_begin && f.t_end == g.t_end && f.y_begin == g.y_begin &&
                  f.rate == g.rate && f.peak == g.peak)
          << hard.name;
    }
  }
}

/// Coordinates of hard kernels, and random ones at every scale, tangent ones among them.
template <class T>
RayCoordinates<T> some_coordinates(Random& random) {
  if (random() % 3 == 0) {
    const auto& cases = oracle::hard_cases();
    const auto [kernel, x, y] = cases[random() % cases.size()].make(random);
    return KernelPlane<T>(kernel).along(static_cast<T>(x), static_cast<T>(y));
  }
  return oracle::planted_coordinates<T>(random);
}

template <class T, class Intersect>
oracle::TubeError worst_tube(Intersect intersect, int count, unsigned seed) {
  Random random(seed);
  oracle::TubeError worst;
  for (int i = 0; i < count; ++i) {
    const RayCoordinates<T> ray = some_coordinates<T>(random);
    const double all[] = {ray.u, ray.v, ray.z, ray.du, ray.dv, ray.dz};
    if (!std::all_of(std::begin(all), std::end(all), [](double v) { return std::isfinite(v); })) continue;
    const T delta = static_cast<T>(uniform(random, 0.5, 50.0));
    const T begin = random() % 2 ? T(0) : T(0.25), end = T(1);
    worst.include(oracle::tube_error(ray, begin, end, static_cast<T>(oracle::near_depth), delta, intersect));
  }
  return worst;
}

constexpr auto stable = []<class T>(const RayCoordinates<T>& ray, T begin, T end, T near, T delta, T weight,
                                    RayFragment<T>& f) {
  return intersect_tube(ray, begin, end, near, delta, weight, f);
};
constexpr auto textbook = []<class T>(const RayCoordinates<T>& ray, T begin, T end, T near, T delta, T weight,
                                      RayFragment<T>& f) {
  return naive::intersect_tube(ray, begin, end, near, delta, weight, f);
};

template <class T>
void expect_stable() {
  const oracle::TubeError worst = worst_tube<T>(stable, 20000, 4);
  EXPECT_GT(worst.hits, 5000);
  EXPECT_LE(worst.interval, 1.0);
  EXPECT_LE(worst.missed, 1.0);
  EXPECT_LE(worst.y, 1.0);
  EXPECT_LE(worst.z, 1.0);
  EXPECT_LE(worst.peak, 1.0);
}

TEST(IntersectTube, IsBackwardStableInDouble) { expect_stable<double>(); }
TEST(IntersectTube, IsBackwardStableInFloat) { expect_stable<float>(); }

TEST(IntersectTube, TheCheckCatchesTheTextbookQuadratic) {
  const oracle::TubeError worst = worst_tube<double>(textbook, 2000, 4);
  EXPECT_FALSE(worst.interval <= 10.0 && worst.missed <= 10.0);
  EXPECT_FALSE(worst.peak <= 10.0);
  const oracle::TubeError in_float = worst_tube<float>(textbook, 2000, 4);
  EXPECT_FALSE(in_float.interval <= 10.0 && in_float.missed <= 10.0);
}

/// Kernels of all magnitudes a number has: fragments are finite, ordered and inside their segment.
template <class T>
void expect_finite() {
  Random random(5);
  // Any bit pattern of a finite number, and often a zero or an ordinary one.
  const auto any = [&](double largest) {
    switch (random() % 6) {
      case 0:
        return 0.0;
      case 1:
      case 2:
        return uniform(random, -2.0, 2.0);
      case 3:
        return (random() % 2 ? 1.0 : -1.0) * largest;
      default:
        return std::ldexp(uniform(random, -1.0, 1.0),
                          static_cast<int>(uniform(random, -1074.0, std::log2(largest))));
    }
  };
  int hits = 0;
  for (int i = 0; i < 300000; ++i) {
    MovingKernel kernel;
    for (int k = 0; k < 3; ++k) {
      kernel.center[k] = any(std::numeric_limits<double>::max());
      kernel.velocity[k] = any(std::numeric_limits<double>::max());
      kernel.axis_u[k] = static_cast<float>(any(std::numeric_limits<float>::max()));
      kernel.axis_v[k] = static_cast<float>(any(std::numeric_limits<float>::max()));
    }
    kernel.facing.setZero();
    const T x = static_cast<T>(uniform(random, -2.0, 2.0)), y = random() % 3 ? x : T(0);
    const T near = random() % 2 ? T(0.001) : std::numeric_limits<T>::min();
    RayFragment<T> f;
    if (!intersect_tube(KernelPlane<T>(kernel).along(x, y), T(0), T(1), near, T(3), T(1), f)) continue;
    ++hits;
    ASSERT_TRUE(T(0) <= f.t_begin && f.t_begin < f.t_end && f.t_end <= T(1)) << i;
    ASSERT_TRUE(T(0) <= f.peak && f.peak <= T(1)) << i;
    for (const T value : {f.y_begin, f.rate, f.z_begin, f.z_rate}) ASSERT_TRUE(std::isfinite(value)) << i;
    const T y_end = f.y_begin + f.rate * (f.t_end - f.t_begin);
    const T mean = mean_gaussian(std::min(f.y_begin, y_end), std::max(f.y_begin, y_end));
    ASSERT_TRUE(mean >= T(0) && mean <= T(1)) << i;
  }
  EXPECT_GT(hits, 1000);
}

TEST(IntersectTube, FragmentsOfFiniteKernelsAreFinite) {
  expect_finite<double>();
  expect_finite<float>();
}

TEST(IntersectTube, CoordinatesThatAreNotFiniteAreAMiss) {
  const double infinity = std::numeric_limits<double>::infinity(),
               nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {infinity, -infinity, nan})
    for (int field = 0; field < 6; ++field) {
      RayCoordinates<double> ray{0.1, 0.2, 3.0, 0.3, -0.4, 0.5};
      (&ray.u)[field] = bad;
      RayFragment<double> f;
      EXPECT_FALSE(intersect_tube(ray, 0.0, 1.0, 0.1, 3.0, 1.0, f)) << field << " " << bad;
    }
}

/// The mirrored motion. Entry is t_mid + q and exit of the mirrored tube t_mid − q with the same q, so they
/// differ from mirror images by the rounding of the two sums.
TEST(IntersectTube, ReversedTimeGivesTheMirroredIntegral) {
  Random random(6);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    RayCoordinates<double> ray = oracle::planted_coordinates<double>(random), reversed = ray;
    reversed.du = -ray.du;
    reversed.dv = -ray.dv;
    reversed.dz = -ray.dz;
    const double delta = 3.0;
    RayFragment<double> f, g;
    const bool hit = intersect_tube(ray, 0.0, 1.0, oracle::near_depth, delta, 1.0, f);
    if (hit != intersect_tube(reversed, 0.0, 1.0, oracle::near_depth, delta, 1.0, g)) {
      EXPECT_LE(hit ? f.t_end - f.t_begin : g.t_end - g.t_begin, 2 * unit_roundoff);
      continue;
    }
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(f.t_begin, 1.0 - g.t_end, 2 * unit_roundoff);
    EXPECT_NEAR(f.t_end, 1.0 - g.t_begin, 2 * unit_roundoff);
    EXPECT_EQ(f.peak, g.peak);
    const auto integral = [](const RayFragment<double>& h) {
      const double d = h.t_end - h.t_begin;
      return interval_integral(h.peak, d, h.y_begin, h.y_begin + h.rate * d);
    };
    // The ends' error, and that of y at either end, |d exp(−y²)/dy| being below 0.86.
    const double duration = f.t_end - f.t_begin;
    const double w = std::hypot(ray.u, ray.v), s = std::hypot(ray.du, ray.dv);
    const double bound = f.peak * unit_roundoff *
                         (4 + duration * 0.86 * 2 * 26 * std::sqrt(delta) * (1 + w + s) + 16 * duration);
    EXPECT_NEAR(integral(f), integral(g), bound);
  }
  EXPECT_GT(hits, 5000);
}

/// ρ at a time within the fragment.
double rho(const RayFragment<double>& f, double t) {
  const double y = f.y_begin + f.rate * (t - f.t_begin);
  return f.peak * std::exp(-y * y);
}

/// As motion fades out, the moving form goes over into the still one, by no more than the kernel's greatest
/// slope √(2δ/e) times the way gone and the stated roundings.
TEST(IntersectTube, SlowMotionIsContinuousWithNone) {
  Random random(7);
  const double delta = 3.0;
  for (int i = 0; i < 2000; ++i) {
    const double angle = uniform(random, 0.0, 6.28), reach = uniform(random, 0.0, 0.99);
    const RayCoordinates<double> still{reach * std::cos(angle), reach * std::sin(angle), 2.0, 0.0, 0.0, 0.0};
    RayFragment<double> f;
    ASSERT_TRUE(intersect_tube(still, 0.0, 1.0, 0.1, delta, 1.0, f));
    const double expected = rho(f, 0.3);
    for (double speed : {1e-2, 1e-6, 1e-10, 1e-16, 1e-100, 1e-307, 1e-308, 5e-324}) {
      RayCoordinates<double> ray = still;
      const double heading = uniform(random, 0.0, 6.28);
      ray.du = speed * std::cos(heading);
      ray.dv = speed * std::sin(heading);
      ASSERT_TRUE(intersect_tube(ray, 0.0, 1.0, 0.1, delta, 1.0, f));
      EXPECT_EQ(f.t_begin, 0.0);
      EXPECT_EQ(f.t_end, 1.0);
      const double slope = std::sqrt(2.0 * delta / std::exp(1.0));
      EXPECT_NEAR(rho(f, 0.3), expected, slope * 0.5 * speed + unit_roundoff * (60 * delta + 20)) << speed;
    }
  }
}

/// The exact speed at which a motion starts to count, found by bisection.
TEST(IntersectTube, TheSwitchToMotionDoesNotShow) {
  const auto fragment = [](double speed) {
    RayFragment<double> f;
    EXPECT_TRUE(intersect_tube<double>({0.5, -0.3, 2.0, speed, 0.0, 0.0}, 0.0, 1.0, 0.1, 3.0, 1.0, f));
    return f;
  };
  double still = 0.0, moving = 1.0;
  while (std::nextafter(still, moving) < moving) {
    const double middle = still + (moving - still) / 2;
    if (middle == still) break;
    (fragment(middle).rate > 0.0 ? moving : still) = middle;
  }
  ASSERT_EQ(fragment(still).rate, 0.0);
  ASSERT_GT(fragment(moving).rate, 0.0);
  EXPECT_NEAR(rho(fragment(still), 0.5), rho(fragment(moving), 0.5), 80 * unit_roundoff);
}

}  // namespace
}  // namespace swept
