// Scenes of finite numbers of any magnitude: they validate, so they must render, to finite pixels.
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "splat/kernel/kernel_set.h"

namespace swept {
namespace {

using Random = std::mt19937_64;

/// Zero, ordinary, the largest, or of any exponent.
double any(Random& random, double largest) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double x = unit(random);
  switch (random() % 6) {
    case 0:
      return 0.0;
    case 1:
    case 2:
      return x;
    case 3:
      return std::copysign(largest, x);
    default: {
      const double exponents = 1074.0 + std::log2(largest);
      return std::ldexp(x, static_cast<int>(0.5 * (unit(random) + 1.0) * exponents) - 1074);
    }
  }
}

Eigen::Vector3d any_vector(Random& random) {
  constexpr double largest = std::numeric_limits<double>::max();
  const double x = any(random, largest), y = any(random, largest);
  return {x, y, any(random, largest)};
}

Eigen::Vector3f any_float_vector(Random& random) {
  constexpr double largest = std::numeric_limits<float>::max();
  const double x = any(random, largest), y = any(random, largest);
  return Eigen::Vector3d(x, y, any(random, largest)).cast<float>();
}

Scene any_scene(Random& random) {
  Scene scene;
  scene.film = {16, 12, 0, 0, 0, 0};
  scene.shutter = {-0.5, 0.5};
  CameraKey pose;
  pose.eye = random() % 2 ? Eigen::Vector3d(0.0, 0.0, -5.0) : any_vector(random);
  scene.camera.poses.push_back(pose);
  scene.camera.near = random() % 3 ? 1e-3 : 1e-300;
  Object object;
  object.two_sided = random() % 2 == 0;
  object.segments = static_cast<int>(random() % 4);
  SurfelPose discs;
  for (int i = 0; i < 20; ++i) {
    discs.position.push_back(any_vector(random));
    discs.axis_u.push_back(any_float_vector(random));
    discs.axis_v.push_back(any_float_vector(random));
    object.cloud.velocity.push_back(any_float_vector(random));
  }
  object.cloud.keys.push_back({0.0, std::move(discs)});
  scene.objects.push_back(std::move(object));
  return scene;
}

/// Among them: centres whose place along the sorting curve was not a number, and depths beyond a float's
/// range, which the sweep compared.
TEST(ExtremeScene, RendersToFinitePixels) {
  Random random(1);
  std::size_t kernels = 0;
  bool any_seen = false;
  for (int i = 0; i < 300; ++i) {
    const Scene scene = any_scene(random);
    ASSERT_TRUE(scene.validate()) << i;
    for (const MovingKernel& kernel : build_kernels(scene).kernels) {
      ++kernels;
      ASSERT_TRUE(kernel.center.allFinite() && kernel.velocity.allFinite()) << i;
      ASSERT_TRUE(kernel.axis_u.allFinite() && kernel.axis_v.allFinite() && kernel.facing.allFinite()) << i;
    }
    const auto rendered = render_abuffer(scene);
    ASSERT_TRUE(rendered) << i;
    for (const float value : rendered->image.rgba) {
      ASSERT_TRUE(std::isfinite(value)) << i;
      any_seen = any_seen || value > 0.0f;
    }
    for (const float depth : rendered->image.depth) ASSERT_FALSE(std::isnan(depth)) << i;
  }
  EXPECT_GT(kernels, 500u);
  EXPECT_TRUE(any_seen);
}

}  // namespace
}  // namespace swept
