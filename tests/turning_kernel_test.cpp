// Kernels whose discs turn, grow or come nearer along a segment: what a ray sees of one, where it may be on
// the film, and how good pictures are.
#include "splat/kernel/turning_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/sampled.h"
#include "tests/image_difference.h"
#include "tests/seen_kernel.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;

using test::kernel_delta;
using test::place_at;
using test::Seen;
using test::seen_by_instants;
using test::seen_of;

constexpr double near_depth = 0.1;

/// In a part of the exposure, so that times are not those of the segment.
MovingKernel kernel_moving(const Vector3d& velocity) {
  MovingKernel kernel;
  kernel.center = {0.03, 0.02, 4.0};
  kernel.velocity = velocity;
  kernel.axis_u = {0.1f, 0.0f, 0.02f};
  kernel.axis_v = {0.0f, 0.06f, 0.01f};
  kernel.facing.setZero();
  kernel.weight = 0.6f;
  kernel.t_begin = 0.25f;
  kernel.t_end = 0.75f;
  kernel.color.setOnes();
  return kernel;
}

/// A quarter of itself larger at the end than at the begin, turned by a tenth of a radian, seen better.
DiscTurn turn_of(const MovingKernel& kernel) {
  const auto disc = [&](double s) {
    const double c = std::cos(0.1 * s), n = std::sin(0.1 * s), grown = 1.0 + 0.12 * s;
    const Vector3d u = kernel.axis_u.cast<double>(), v = kernel.axis_v.cast<double>();
    const auto turned = [&](const Vector3d& a) -> Vector3d {
      return grown * Vector3d(c * a.x() - n * a.z(), a.y(), n * a.x() + c * a.z());
    };
    return FilteredDisc{turned(u), turned(v), 0.6 * (1.0 + 0.2 * s + 0.02 * s * s), 0.0};
  };
  return turn_through(disc(-1.0), kernel, disc(1.0));
}

/// How far what a ray sees is from what instants show, of rays about the path: light, of the most that any
/// sees, and the middle of its time and depth.
Seen worst_of(const MovingKernel& kernel, const DiscTurn& turn, const auto& intersect) {
  Seen worst;
  double most = 0.0;
  for (int k = 0; k < 12; ++k)
    for (int j = -2; j <= 2; ++j) {
      const Vector3d at = place_at(kernel, 0.25 + 0.5 * k / 11);
      const double x = at.x() / at.z() + 0.004 * j, y = at.y() / at.z() + 0.003 * j;
      const Seen expected = seen_by_instants(kernel, &turn, x, y);
      RayFragment<double> fragment{};
      const Seen seen = intersect(x, y, fragment) ? seen_of(fragment) : Seen{};
      most = std::max(most, expected.light);
      worst.light = std::max(worst.light, std::abs(seen.light - expected.light));
      if (expected.light < 1e-3 || !(seen.light > 0.0)) continue;
      worst.depth =
          std::max(worst.depth, std::abs(seen.depth / seen.light - expected.depth / expected.light));
      worst.time = std::max(worst.time, std::abs(seen.time / seen.light - expected.time / expected.light));
    }
  worst.light /= most;
  return worst;
}

/// Both light and its time are ten times as near as with the axes of the middle, or as near as nobody sees.
void expect_what_instants_show(const MovingKernel& kernel, const char* name) {
  const DiscTurn turn = turn_of(kernel);
  const TurningPlane plane(kernel, turn, 0.0, false);
  const Seen turning = worst_of(kernel, turn, [&](double x, double y, RayFragment<double>& fragment) {
    return plane.intersect(x, y, near_depth, kernel_delta, fragment);
  });
  const Seen frozen = worst_of(kernel, turn, [&](double x, double y, RayFragment<double>& fragment) {
    return intersect_tube<double>(KernelPlane<double>(kernel).along(x, y), kernel.t_begin, kernel.t_end,
                                  near_depth, kernel_delta, kernel.weight, fragment);
  });
  std::printf(
      "%s: light off by %.4f of the most, time by %.1e, depth by %.1e; with the middle's axes %.4f, %.1e, "
      "%.1e\n",
      name, turning.light, turning.time, turning.depth, frozen.light, frozen.time, frozen.depth);
  EXPECT_LT(turning.light, std::max(0.01, 0.1 * frozen.light)) << name;
  EXPECT_LT(turning.time, std::max(3e-3, 0.1 * frozen.time)) << name;
  EXPECT_LT(turning.depth, 2e-3) << name;
}

TEST(TurningKernel, ARaySeesWhatInstantsShow) {
  expect_what_instants_show(kernel_moving({0.0, 0.0, 0.0}), "in its place");
  expect_what_instants_show(kernel_moving({0.1, 0.02, 0.8}), "hardly aside, and away");
  expect_what_instants_show(kernel_moving({2.0, 0.5, -0.3}), "by ten times its width");
  MovingKernel bent = kernel_moving({2.0, 0.5, 0.0});
  bent.bend = {0.05, -0.25, 0.02};
  expect_what_instants_show(bent, "on a parabola");
}

/// What a part of the exposure has of it is what the whole has there, if its times are counted from later,
/// too.
TEST(TurningKernel, APartOfItIsWhatItWas) {
  const MovingKernel whole = kernel_moving({0.4, 0.1, 0.2});
  const DiscTurn turn = turn_of(whole);
  MovingKernel part = whole;
  constexpr double later = 0.125;
  part.t_begin = 0.35f - static_cast<float>(later);
  part.t_end = 0.5f - static_cast<float>(later);
  part.keep_part(double{part.t_mid()} + later - double{whole.t_mid()}, whole.half_time());
  const TurningPlane of_whole(whole, turn, 0.0, false), of_part(part, turn, later, false);
  RayFragment<double> a{}, b{};
  const Vector3d at = place_at(whole, 0.42);
  ASSERT_TRUE(of_whole.intersect(at.x() / at.z(), at.y() / at.z(), near_depth, kernel_delta, a));
  ASSERT_TRUE(of_part.intersect(at.x() / at.z(), at.y() / at.z(), near_depth, kernel_delta, b));
  for (const double time : {0.36, 0.4, 0.49}) {
    const auto value = [&](const RayFragment<double>& f, double t) {
      const double y = f.y_begin + f.rate * (t - f.t_begin);
      return f.peak * std::exp(-y * y);
    };
    EXPECT_NEAR(value(b, time - later), value(a, time), 0.02);
    EXPECT_NEAR(b.z_begin + b.z_rate * (time - later - b.t_begin), a.z_begin + a.z_rate * (time - a.t_begin),
                2e-3);
  }
}

TEST(TurningKernel, BoundsContainIt) {
  const Projection film{400.0, 64.0, 48.0};
  test::Random random(5);
  for (int k = 0; k < 400; ++k) {
    MovingKernel kernel = kernel_moving(random.vector(-4.0, 4.0));
    kernel.center = random.vector(-1.0, 1.0) + Vector3d(0.0, 0.0, k % 2 == 0 ? 5.0 : 0.8);
    if (k % 3 == 0) kernel.bend = random.vector(-3.0, 3.0);
    kernel.axis_u = random.vector(-0.2, 0.2).cast<float>();
    kernel.axis_v = random.vector(-0.2, 0.2).cast<float>();
    DiscTurn turn;
    turn.u_rate = random.vector(-0.4, 0.4).cast<float>();
    turn.v_rate = random.vector(-0.4, 0.4).cast<float>();
    turn.u_bend = random.vector(-1.0, 1.0).cast<float>();
    turn.v_bend = random.vector(-1.0, 1.0).cast<float>();
    turn.t_mid = kernel.t_mid();
    Octagon octagon;
    const bool any = turning_bounds(kernel, turn, film, near_depth, octagon);
    for (int i = 0; i <= 20; ++i)
      for (int j = 0; j < 16; ++j) {
        const double angle = j * std::numbers::pi / 8.0, time = kernel.t_begin + i / 40.0;
        const DiscTurn::Axes axes = turn.at(kernel, time);
        const Vector3d p = place_at(kernel, time) + std::cos(angle) * axes.u + std::sin(angle) * axes.v;
        if (p.z() < near_depth) continue;
        ASSERT_TRUE(any);
        const double x = film.center_x + film.focal_px * p.x() / p.z(),
                     y = film.center_y + film.focal_px * p.y() / p.z();
        double low = 0.0, high = 0.0;
        ASSERT_TRUE(octagon.span(y, y, low, high) && low <= x && x <= high) << k;
      }
  }
}

TEST(TurningKernel, WhatIsNotANumberIsAMiss) {
  const MovingKernel kernel = kernel_moving({0.4, 0.1, 0.2});
  for (const float bad : {std::nanf(""), HUGE_VALF}) {
    DiscTurn turn = turn_of(kernel);
    turn.u_rate.x() = bad;
    RayFragment<double> fragment{};
    EXPECT_FALSE(
        TurningPlane(kernel, turn, 0.0, false).intersect(0.01, 0.005, near_depth, kernel_delta, fragment));
  }
}

Scene flying(unsigned seed) {
  Scene scene = test::stage();
  Object object;
  test::Random random(seed);
  for (int i = 0; i < 200; ++i) {
    test::add_disc(object, random.vector(-1.4, 1.4), random.vector(-1.0, 1.0).normalized(),
                   random(0.05, 0.25), random.vector(0.0, 1.0).cast<float>());
    object.cloud.velocity.emplace_back(0.3f, -0.2f, static_cast<float>(random(0.5, 2.0)));
  }
  scene.objects = {object};
  return scene;
}

double psnr_of(const Scene& scene, const char* name) {
  SampledOptions many;
  many.samples = 1024;
  const auto truth = render_sampled(scene, many), exact = render_abuffer(scene);
  EXPECT_TRUE(truth.ok() && exact.ok()) << name;
  const double db = -20.0 * std::log10(test::difference_of(exact->image, truth->image).color);
  std::printf("%s: %.1f dB, %.1f segments a point\n", name, db,
              exact->statistics.counter("kernels").value_or(0.0) / 200.0);
  return db;
}

/// The filter, the weight and the depth tolerance change along each segment; rows have them at their own
/// times.
TEST(TurningKernel, DiscsThatComeNearerAreRightUnasked) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Scene scene = flying(seed);
    EXPECT_GE(psnr_of(scene, "discs that come nearer"), 70.0) << seed;
    scene.shutter.row_delay = 0.01;
    EXPECT_GE(psnr_of(scene, "row by row"), 70.0) << seed;
  }
}

TEST(TurningKernel, OrderOfPointsAndTilesChangeNoBit) {
  Scene scene = flying(4);
  const auto first = render_abuffer(scene);
  ASSERT_TRUE(first.ok());
  test::reverse_points(scene.objects[0].cloud);
  const auto second = render_abuffer(scene, {.tile_px = 7, .tile_fragments = 300});
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(second->image.rgba, first->image.rgba);
  EXPECT_EQ(second->image.depth, first->image.depth);
}

}  // namespace
}  // namespace swept
