// The octagon contains what the kernel covers: densely sampled in time, on the disc and over pixels.
#include "splat/kernel/screen_bounds.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "splat/kernel/ray_kernel.h"
#include "tests/oracle/hard_kernels.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using oracle::uniform;

constexpr double near_depth = oracle::near_depth;
const Projection film{oracle::focal_px, 32.0, 24.0};

Vector3d point_at(const MovingKernel& kernel, double tau, double u, double v) {
  return kernel.center + (tau - 0.5) * kernel.velocity + u * kernel.axis_u.cast<double>() +
         v * kernel.axis_v.cast<double>();
}

/// Whether octagon, its box and its rows all contain the point.
bool contains(const Octagon& octagon, double x, double y) {
  const PixelBox box = octagon.box();
  if (!(box.x_min <= x && x <= box.x_max && box.y_min <= y && y <= box.y_max)) return false;
  double x_min, x_max;
  if (!octagon.span(y, y, x_min, x_max) || !(x_min <= x && x <= x_max)) return false;
  return octagon.overlaps({x, x, y, y});
}

/// Points of the disc at z ≥ near, over time; half of them on its rim and a third at the segment's ends.
int points_outside(const MovingKernel& kernel, Random& random, const Octagon& octagon, bool any) {
  int outside = 0;
  for (int i = 0; i < 300; ++i) {
    const double angle = uniform(random, 0.0, 2.0 * std::numbers::pi);
    const double radius = i % 2 ? 1.0 : std::sqrt(uniform(random, 0.0, 1.0));
    const double tau = i % 3 ? uniform(random, 0.0, 1.0) : double(i / 3 % 2);
    const Vector3d p = point_at(kernel, tau, radius * std::cos(angle), radius * std::sin(angle));
    if (p.z() < near_depth) continue;
    const double x = film.center_x + film.focal_px * p.x() / p.z(),
                 y = film.center_y + film.focal_px * p.y() / p.z();
    if (!any || !contains(octagon, x, y)) ++outside;
  }
  return outside;
}

TEST(ScreenBounds, ContainEveryPointOfTheTube) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    Random random(1);
    for (int i = 0; i < 150; ++i) {
      const MovingKernel kernel = hard.make(random).kernel;
      Octagon octagon;
      const bool any = screen_bounds(kernel, film, near_depth, octagon);
      ASSERT_EQ(points_outside(kernel, random, octagon, any), 0) << hard.name << " " << i;
    }
  }
}

/// The same for discs that went through the pixel filter, as all in a picture have.
TEST(ScreenBounds, ContainFilteredDiscs) {
  PixelFilter filter;
  filter.radius = 1.0 / oracle::focal_px;
  filter.near = near_depth;
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    Random random(2);
    for (int i = 0; i < 100; ++i) {
      MovingKernel kernel = hard.make(random).kernel;
      const FilteredDisc disc =
          filter_disc(kernel.center, kernel.axis_u.cast<double>(), kernel.axis_v.cast<double>(), filter);
      kernel.axis_u = disc.axis_u.cast<float>();
      kernel.axis_v = disc.axis_v.cast<float>();
      Octagon octagon;
      const bool any = screen_bounds(kernel, film, near_depth, octagon);
      ASSERT_EQ(points_outside(kernel, random, octagon, any), 0) << hard.name << " " << i;
    }
  }
}

struct Coverage {
  int pixels = 0, missed = 0;
};

/// Every pixel centre of the film that the kernel covers, against the given bounds.
template <class Bounds>
Coverage covered_pixels(const MovingKernel& kernel, Bounds bounds) {
  const KernelPlane<double> plane(kernel);
  Octagon octagon;
  const bool any = bounds(kernel, octagon);
  Coverage coverage;
  for (int j = 0; j < 48; ++j)
    for (int i = 0; i < 64; ++i) {
      const double x = i + 0.5, y = j + 0.5;
      RayFragment<double> fragment;
      if (!intersect_tube(
              plane.along((x - film.center_x) / film.focal_px, (y - film.center_y) / film.focal_px), 0.0, 1.0,
              near_depth, 3.0, 1.0, fragment))
        continue;
      ++coverage.pixels;
      if (!any || !contains(octagon, x, y)) ++coverage.missed;
    }
  return coverage;
}

constexpr auto real_bounds = [](const MovingKernel& kernel, Octagon& octagon) {
  return screen_bounds(kernel, film, near_depth, octagon);
};

/// Moved to where the film is, which at 1000 px of focal length is the middle of the field.
MovingKernel on_film(MovingKernel kernel) {
  kernel.center.head<2>() *= 0.06;
  return kernel;
}

TEST(ScreenBounds, RasterizationMissesNoCoveredPixel) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    Random random(3);
    int pixels = 0;
    for (int i = 0; i < 40; ++i) {
      const Coverage coverage = covered_pixels(on_film(hard.make(random).kernel), real_bounds);
      pixels += coverage.pixels;
      ASSERT_EQ(coverage.missed, 0) << hard.name << " " << i;
    }
    // Degenerate discs cover nothing; discs far below a pixel rarely do.
    const bool none =
        hard.name == "an axis of length zero" || hard.name == "parallel axes" || hard.name == "sub-pixel";
    if (!none) {
      EXPECT_GT(pixels, 20) << hard.name;
    }
  }
}

/// Bounds that take the projection of the centre and of the axes' ends fail the same test.
TEST(ScreenBounds, TheCheckCatchesProjectedAxes) {
  const auto projected_axes = [](const MovingKernel& kernel, Octagon& octagon) {
    const auto box_at = [&](double tau) {
      PixelBox box{1e300, -1e300, 1e300, -1e300};
      for (const auto& [u, v] : {std::pair{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}}) {
        const Vector3d p = point_at(kernel, tau, u, v);
        const double x = film.center_x + film.focal_px * p.x() / p.z(),
                     y = film.center_y + film.focal_px * p.y() / p.z();
        box = {std::min(box.x_min, x), std::max(box.x_max, x), std::min(box.y_min, y),
               std::max(box.y_max, y)};
      }
      return box;
    };
    octagon = {box_at(0.0), box_at(1.0)};
    return true;
  };
  Random random(3);
  int missed = 0;
  for (int i = 0; i < 40; ++i)
    missed += covered_pixels(on_film(oracle::hard_cases()[0].make(random).kernel), projected_axes).missed;
  EXPECT_GT(missed, 0);
}

/// An octagon is no looser than its pieces: it leaves out the corners that a box of the whole would have.
TEST(ScreenBounds, ADiagonalStreakIsNarrowerThanItsBox) {
  MovingKernel kernel;
  kernel.center = {0.0, 0.0, 2.0};
  kernel.velocity = {1.0, 1.0, 0.0};
  kernel.axis_u = {0.002f, 0.0f, 0.0f};
  kernel.axis_v = {0.0f, 0.002f, 0.0f};
  Octagon octagon;
  ASSERT_TRUE(screen_bounds(kernel, film, near_depth, octagon));
  double x_min, x_max;
  ASSERT_TRUE(octagon.span(24.0, 24.0, x_min, x_max));
  // 1 px of radius in x, as much again from the rows the disc spans, and padding.
  EXPECT_GT(x_max - x_min, 2.0);
  EXPECT_LT(x_max - x_min, 4.1);
  const PixelBox box = octagon.box();
  EXPECT_FALSE(octagon.overlaps({box.x_max - 1, box.x_max, box.y_min, box.y_min + 1}));
}

/// Nothing a caller might convert to an integer is NaN, and order holds.
TEST(ScreenBounds, AreNumbersForFiniteInput) {
  Random random(4);
  const auto any = [&](int largest) {
    return random() % 4 ? std::ldexp(uniform(random, -1.0, 1.0),
                                     static_cast<int>(uniform(random, -1074.0, double(largest))))
                        : uniform(random, -2.0, 2.0);
  };
  int bounded = 0;
  for (int i = 0; i < 100000; ++i) {
    MovingKernel kernel;
    for (int k = 0; k < 3; ++k) {
      kernel.center[k] = any(1000);
      kernel.velocity[k] = any(1000);
      kernel.axis_u[k] = static_cast<float>(any(127));
      kernel.axis_v[k] = static_cast<float>(any(127));
    }
    Octagon octagon;
    if (!screen_bounds(kernel, film, random() % 2 ? near_depth : 1e-300, octagon)) continue;
    ++bounded;
    for (const PixelBox& box : {octagon.begin, octagon.end}) {
      ASSERT_LE(box.x_min, box.x_max) << i;
      ASSERT_LE(box.y_min, box.y_max) << i;
    }
    double x_min, x_max;
    if (octagon.span(0.5, 0.5, x_min, x_max)) {
      ASSERT_LE(x_min, x_max) << i;
    }
  }
  EXPECT_GT(bounded, 30000);
}

TEST(ScreenBounds, WhollyNearerIsNothing) {
  MovingKernel kernel;
  kernel.center = {0.0, 0.0, -1.0};
  kernel.velocity = {0.0, 0.0, 0.5};
  kernel.axis_u = {1.0f, 0.0f, 0.0f};
  kernel.axis_v = {0.0f, 1.0f, 0.1f};
  Octagon octagon;
  EXPECT_FALSE(screen_bounds(kernel, film, near_depth, octagon));
}

}  // namespace
}  // namespace swept
