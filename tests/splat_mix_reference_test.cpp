// Splats, discs and meshes in one picture, held to the slow reference at the same instants.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/reference/reference.h"
#include "tests/drawn.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using test::psnr_db;

/// Discs between depths 4 and 10, some opaque, each its own way.
Object discs(unsigned seed, bool moving) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> any(-1.0f, 1.0f);
  const auto next = [&] { return any(generator); };
  Object object;
  SurfelKey& key = object.cloud.keys.emplace_back();
  for (int i = 0; i < 60; ++i) {
    const float z = 7.0f + 3.0f * next();
    key.pose.position.emplace_back(0.7 * z * next(), 0.45 * z * next(), z);
    const Eigen::Vector3f normal = Eigen::Vector3f(0.4f * next(), 0.4f * next(), -1.0f).normalized(),
                          u = normal.cross(Eigen::Vector3f(0.1f, 1.0f, 0.2f)).normalized();
    const float radius = 0.3f + 0.25f * next();
    key.pose.axis_u.emplace_back(radius * u);
    key.pose.axis_v.emplace_back(radius * normal.cross(u));
    object.cloud.color.emplace_back(0.5f + 0.5f * next(), 0.5f + 0.5f * next(), 0.5f + 0.5f * next());
    object.cloud.opacity.push_back(i % 3 == 0 ? 1.0f : 0.5f + 0.4f * next());
    if (moving) object.cloud.velocity.emplace_back(0.6f * next(), 0.6f * next(), 0.6f * next());
  }
  return object;
}

/// A pleated sheet across the picture, from front to back, with corners of all opacities.
Object mesh(unsigned seed, bool moving) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> any(-1.0f, 1.0f);
  const auto next = [&] { return any(generator); };
  Object object;
  SurfelKey& key = object.cloud.keys.emplace_back();
  constexpr std::uint32_t columns = 9, rows = 5;
  for (std::uint32_t y = 0; y < rows; ++y)
    for (std::uint32_t x = 0; x < columns; ++x) {
      const double z = 7.0 + 2.0 * double{next()};
      key.pose.position.emplace_back(z * (0.16 * x - 0.64), z * (0.18 * y - 0.36), z);
      key.pose.axis_u.emplace_back(0.1f, 0.0f, 0.0f);
      key.pose.axis_v.emplace_back(0.0f, 0.1f, 0.0f);
      object.cloud.color.emplace_back(0.5f + 0.5f * next(), 0.5f + 0.5f * next(), 0.5f + 0.5f * next());
      object.cloud.opacity.push_back(std::min(1.0f, 0.8f + 0.4f * next()));
      if (moving) object.cloud.velocity.emplace_back(0.5f * next(), 0.5f * next(), 0.5f * next());
    }
  for (std::uint32_t y = 0; y + 1 < rows; ++y)
    for (std::uint32_t x = 0; x + 1 < columns; ++x) {
      const std::uint32_t a = y * columns + x;
      object.triangles.push_back({a, a + 1, a + columns});
      object.triangles.push_back({a + 1, a + columns + 1, a + columns});
    }
  return object;
}

Scene mix(unsigned seed, bool moving) {
  Scene scene = test::random_splats(500, seed);
  scene.background = {0.2f, 0.4f, 0.1f, 0.5f};
  if (!moving) scene.objects[0].splats.velocity.clear();
  scene.objects.push_back(discs(seed + 1, moving));
  scene.objects.push_back(mesh(seed + 2, moving));
  if (!moving) {
    scene.shutter = {0.0, 0.0};
    return scene;
  }
  LookAtKey to = scene.camera.look_ats[0];
  to.frame = 1.0;
  to.eye.x() += 0.3, to.eye.z() += 0.2;
  scene.camera.look_ats.push_back(to);
  scene.objects[2].transform.keys = {{0.0, {0, 0, 0}}, {1.0, {0.2, -0.1, 0.3}}};
  return scene;
}

/// Root mean square of what two pictures' alphas differ by.
double alpha_rmse(const Image& a, const Image& b) {
  double squares = 0.0;
  for (std::size_t i = 3; i < a.rgba.size(); i += 4)
    squares += std::pow(double{a.rgba[i]} - double{b.rgba[i]}, 2);
  return std::sqrt(squares / static_cast<double>(a.pixel_count()));
}

TEST(SplatMixReference, AStillOfAllKindsIsTheReferences) {
  for (const unsigned seed : {61u, 64u}) {
    Scene scene = mix(seed, false);
    for (const SplatBlending blending : {SplatBlending::srgb, SplatBlending::linear}) {
      scene.splats.blending = blending;
      const Image image = test::sampled(scene, 1), truth = test::splat_reference(scene, 1);
      EXPECT_GE(psnr_db(image, truth), 80.0) << seed;
      EXPECT_LE(alpha_rmse(image, truth), 1e-4) << seed;
      // A test that can fail: what lies in front of what matters, and every kind is seen.
      for (std::size_t without = 0; without < scene.objects.size(); ++without) {
        Scene less = scene;
        less.objects.erase(less.objects.begin() + static_cast<std::ptrdiff_t>(without));
        EXPECT_LE(psnr_db(test::sampled(less, 1), truth), 40.0) << without;
      }
    }
  }
}

TEST(SplatMixReference, AtTheSameInstantsABlurredOneIsToo) {
  for (const unsigned seed : {71u, 74u}) {
    const Scene scene = mix(seed, true);
    const Image image = test::sampled(scene, 6), truth = test::splat_reference(scene, 6);
    EXPECT_GE(psnr_db(image, truth), 80.0) << seed;
    EXPECT_LE(alpha_rmse(image, truth), 1e-4) << seed;
  }
}

TEST(SplatMixReference, TheErrorAskedForIsReachedOfAllKinds) {
  const Scene scene = mix(81, true);
  EXPECT_GE(psnr_db(test::sampled(scene, 0), test::splat_reference(scene, 256)), 60.0);
}

TEST(SplatMixReference, DiscsAloneAreThoseOfTheirOwnReference) {
  // A splat that nobody sees brings the one reference into the way of the other.
  Scene scene = mix(91, true), seen_alone;
  scene.objects.erase(scene.objects.begin());
  seen_alone = scene;
  scene.objects.insert(scene.objects.begin(), test::one_splat({0, 0, 5}, 0.1f, 0.0f, 0.5f).objects[0]);
  const Result<Rendered> alone =
      render_reference(seen_alone, {.samples = 4, .motion = ReferenceMotion::smooth});
  ASSERT_TRUE(alone.ok());
  EXPECT_GE(psnr_db(test::splat_reference(scene, 4), alone->image), 120.0);
}

TEST(SplatMixReference, TheOneCallDrawsThemToo) {
  Scene scene = mix(95, true);
  const Result<Rendered> result = render_reference(scene, {.samples = 2});
  ASSERT_TRUE(result.ok()) << result.error().message();
  EXPECT_EQ(result->image.rgba, test::splat_reference(scene, 2).rgba);
}

}  // namespace
}  // namespace swept
