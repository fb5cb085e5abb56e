// Colours and opacities that change during the exposure (model section 1.7): closed forms, and every method
// against the reference, which has formulas of its own.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "abuffer/simd/sampled_math.h"
#include "splat/compare/metrics.h"
#include "splat/kernel/kernel_set.h"
#include "splat/motion/look.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector4d;

Image reference_of(const Scene& scene, int samples = 512) {
  auto rendered = render_reference(scene, {samples, ReferenceMotion::smooth});
  EXPECT_TRUE(rendered.ok()) << rendered.error().message();
  return rendered->image;
}

Image exact_of(const Scene& scene) {
  auto rendered = render_abuffer(scene, {});
  EXPECT_TRUE(rendered.ok()) << rendered.error().message();
  return rendered->image;
}

Image sampled_of(const Scene& scene, int samples, int implementation = -1) {
  SampledOptions options;
  options.samples = samples;
  options.implementation = implementation;
  auto rendered = render_sampled(scene, options);
  EXPECT_TRUE(rendered.ok()) << rendered.error().message();
  return rendered->image;
}

double psnr(const Image& image, const Image& truth) {
  return -20.0 * std::log10(test::difference_of(image, truth).color);
}

void expect_near_reference(const Scene& scene, double exact_db, int samples = 512) {
  const Image truth = reference_of(scene, samples);
  EXPECT_GE(psnr(sampled_of(scene, samples), truth), 100.0) << "the same instants";
  SampledOptions options;
  options.max_error_db = 60.0;
  const auto chosen = render_sampled(scene, options);
  ASSERT_TRUE(chosen.ok());
  EXPECT_GE(psnr(chosen->image, truth), 58.5) << "instants chosen for 60 dB";
  const Image exact = exact_of(scene);
  EXPECT_GE(psnr(exact, truth), exact_db);
  std::printf("sampled to 60 dB %.1f dB, exact %.1f dB\n", psnr(chosen->image, truth), psnr(exact, truth));
}

/// A disc that covers the middle of the film all the time.
Object wall(double z) {
  Object object;
  test::add_disc(object, {0.0, 0.0, z}, Vector3d::UnitZ(), 40.0);
  object.cloud.color.clear();
  return object;
}

LookKey look(double frame, const Vector3f& color, float opacity) { return {frame, {color}, {opacity}}; }

Vector4d middle_of(const Image& image) {
  const std::size_t at =
      4 * (static_cast<std::size_t>(image.height / 2) * static_cast<std::size_t>(image.width) +
           static_cast<std::size_t>(image.width / 2));
  return {image.rgba[at], image.rgba[at + 1], image.rgba[at + 2], image.rgba[at + 3]};
}

TEST(ChangingLooks, LightAndOpacityAreLinearBetweenTwoLooks) {
  Object object = wall(0.0);
  object.cloud.looks = {look(0.0, {1.0f, 0.0f, 0.0f}, 1.0f), look(2.0, {0.0f, 0.0f, 1.0f}, 0.0f)};
  // What is not there at all has no colour to mix in.
  EXPECT_TRUE(LooksAt(object.cloud, 1.0)[0].isApprox(Eigen::Vector4f(0.5f, 0.0f, 0.0f, 0.5f)));
  EXPECT_TRUE(LooksAt(object.cloud, -1.0)[0].isApprox(Eigen::Vector4f(1.0f, 0.0f, 0.0f, 1.0f)));
  EXPECT_TRUE(LooksAt(object.cloud, 3.0)[0].isZero(0.0f));
}

TEST(ChangingLooks, AnEvenFadeIsItsMean) {
  Scene scene = test::stage();
  scene.objects = {wall(0.0)};
  scene.objects[0].cloud.looks = {look(0.0, {1.0f, 0.0f, 0.5f}, 1.0f), look(1.0, {0.0f, 3.0f, 0.5f}, 1.0f)};
  const Vector4d truth(0.5, 1.5, 0.5, 1.0);
  EXPECT_LT((middle_of(exact_of(scene)) - truth).norm(), 1e-6);
  EXPECT_LT((middle_of(sampled_of(scene, 0)) - truth).norm(), 1e-6);
  EXPECT_LT((middle_of(reference_of(scene, 8)) - truth).norm(), 1e-6);
}

TEST(ChangingLooks, AFlashWithinTheExposureIsIntegrated) {
  Scene scene = test::stage();
  scene.objects = {wall(0.0)};
  scene.objects[0].cloud.looks = {look(0.25, {1.0f, 1.0f, 1.0f}, 0.0f), look(0.375, {4.0f, 1.0f, 0.0f}, 1.0f),
                                  look(0.625, {0.0f, 0.0f, 1.0f}, 0.0f)};
  // A triangle of height 1 that is 3/8 long.
  const Vector4d truth(4.0 * 0.1875, 0.1875, 0.0, 0.1875);
  EXPECT_LT((middle_of(exact_of(scene)) - truth).norm(), 1e-6);
  EXPECT_LT((middle_of(sampled_of(scene, 512)) - truth).norm(), 1e-4);
}

TEST(ChangingLooks, AFadeUnderAGaussianShutterIsTheShuttersMean) {
  Scene scene = test::stage();
  scene.shutter.curve = ShutterShape::gaussian;
  scene.objects = {wall(0.0)};
  scene.objects[0].cloud.looks = {look(0.0, {0.0f, 0.0f, 0.0f}, 1.0f), look(0.5, {0.0f, 0.0f, 0.0f}, 1.0f),
                                  look(1.0, {1.0f, 1.0f, 1.0f}, 1.0f)};
  double light = 0.0, all = 0.0;
  constexpr int n = 1 << 20;
  for (int i = 0; i < n; ++i) {
    const double t = (i + 0.5) / n, a = std::exp(-scene.shutter.delta * (2.0 * t - 1.0) * (2.0 * t - 1.0));
    all += a;
    light += a * std::max(0.0, 2.0 * t - 1.0);
  }
  EXPECT_NEAR(middle_of(exact_of(scene)).x(), light / all, 2e-5);
}

TEST(ChangingLooks, WhatIsSeenThroughAFadeIsThePolynomialsIntegral) {
  Scene scene = test::stage();
  scene.model.depth_tolerance = 1e-3;
  // Four layers, each of which fades in as the ones before it fade out.
  for (int k = 0; k < 4; ++k) {
    scene.objects.push_back(wall(1.0 - k));
    const bool in = k % 2 == 0;
    scene.objects.back().cloud.looks = {
        look(0.0, {1.0f, 0.25f * static_cast<float>(k), 0.0f}, in ? 0.0f : 1.0f),
        look(1.0, {0.0f, 1.0f, 0.5f}, in ? 1.0f : 0.0f)};
  }
  Vector4d truth = Vector4d::Zero();
  constexpr int n = 1 << 16;
  for (int i = 0; i < n; ++i) {
    const double t = (i + 0.5) / n;
    double light = 1.0;
    for (int k = 0; k < 4; ++k) {
      const double first = k % 2 == 0 ? 0.0 : 1.0, last = 1.0 - first;
      const double from = (1.0 - t) * first, to = t * last;
      truth += light / n * (from * Vector4d(1.0, 0.25 * k, 0.0, 1.0) + to * Vector4d(0.0, 1.0, 0.5, 1.0));
      light *= 1.0 - from - to;
    }
  }
  EXPECT_LT((middle_of(exact_of(scene)) - truth).norm(), 2e-5);
}

/// A ball that flies, turns and grows while its points change colour and opacity at times of their own.
Scene stress_scene(bool transparent) {
  Scene scene = test::stage();
  Object ball = test::checkered_sphere(0.8, 500);
  SurfelCloud& cloud = ball.cloud;
  test::Random random(11);
  for (const double frame : {-0.4, 0.2, 0.3, 1.4}) {
    LookKey& key = cloud.looks.emplace_back();
    key.frame = frame;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      key.color.push_back(random.vector(0.0, 1.0).cast<float>());
      if (transparent) key.opacity.push_back(static_cast<float>(random(0.0, 1.0)));
    }
  }
  cloud.keys.push_back(cloud.keys[0]);
  cloud.keys[1].frame = 1.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    SurfelPose& pose = cloud.keys[1].pose;
    pose.position[i] = 1.2 * pose.position[i];
    pose.axis_u[i] *= 1.3f;
    pose.axis_v[i] *= 1.3f;
  }
  test::move(ball, {-0.9, -0.3, 0.0}, {0.8, 0.4, 0.3}, 0.5);
  Object behind = test::checkered_sphere(0.9, 400);
  test::move(behind, {0.2, 0.3, -1.5}, {0.1, 0.3, -1.5});
  scene.objects = {ball, behind};
  scene.motion.tolerance_px = 0.02;
  return scene;
}

TEST(ChangingLooks, ChangingColorsAreTheReferences) { expect_near_reference(stress_scene(false), 70.0); }

TEST(ChangingLooks, ChangingOpacitiesAreTheReferences) { expect_near_reference(stress_scene(true), 70.0); }

TEST(ChangingLooks, AreTheReferencesAtTheToleranceThatNobodyAskedFor) {
  for (const bool transparent : {false, true}) {
    Scene scene = stress_scene(transparent);
    scene.motion.tolerance_px = 0.0;
    expect_near_reference(scene, 70.0);
  }
}

TEST(ChangingLooks, FrozenColorsWouldBeSeen) {
  Scene scene = stress_scene(false);
  const Image truth = reference_of(scene, 64);
  SurfelCloud& cloud = scene.objects[0].cloud;
  cloud.color = cloud.looks[1].color;
  cloud.looks.clear();
  EXPECT_LT(psnr(reference_of(scene, 64), truth), 40.0);
}

TEST(ChangingLooks, WhatStandsStillMayChange) {
  Scene scene = stress_scene(true);
  for (Object& object : scene.objects) object.transform = {};
  scene.objects[0].cloud.keys.resize(1);
  expect_near_reference(scene, 75.0);
}

TEST(ChangingLooks, RowsSeeTheLooksOfTheirOwnTime) {
  Scene scene = stress_scene(true);
  scene.film = {40, 30, 0, 0, 0, 0};
  scene.shutter = {0.0, 0.4};
  scene.shutter.row_delay = 0.6 / 30;
  scene.motion.tolerance_px = 0.005;
  const Image truth = reference_of(scene, 128);
  EXPECT_GE(psnr(sampled_of(scene, 128), truth), 95.0);
  EXPECT_GE(psnr(exact_of(scene), truth), 70.0);
}

TEST(ChangingLooks, LivesThatBeginAndEndHaveTheLooksOfTheirTime) {
  Scene scene = stress_scene(true);
  SurfelCloud& cloud = scene.objects[0].cloud;
  test::Random random(5);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double born = random(-0.5, 0.8);
    cloud.lifetime.push_back({born, born + 0.5});
  }
  const Image truth = reference_of(scene, 1024);
  EXPECT_GE(psnr(exact_of(scene), truth), 60.0);
  EXPECT_GE(psnr(sampled_of(scene, 1024), truth), 100.0);
}

TEST(ChangingLooks, ALensSeesThem) {
  Scene scene = stress_scene(false);
  scene.camera.aperture.radius = 0.1;
  scene.camera.aperture.samples = 5;
  scene.camera.look_ats[0].lens.focus = 4.5;
  const Image truth = reference_of(scene, 128);
  EXPECT_GE(psnr(exact_of(scene), truth), 65.0);
}

TEST(ChangingLooks, TrianglesChangeToo) {
  Scene scene = test::stage();
  Object object = stress_scene(true).objects[0];
  for (std::uint32_t i = 0; i + 2 < object.cloud.size(); i += 3)
    object.triangles.push_back({i, i + 1, i + 2});
  scene.objects = {object};
  const Image truth = reference_of(scene, 64);
  EXPECT_GE(psnr(sampled_of(scene, 64), truth), 90.0);
  scene.objects[0].triangles.resize(12);
  EXPECT_GE(psnr(exact_of(scene), sampled_of(scene, 1024)), 70.0);
}

TEST(ChangingLooks, EveryInstructionSetGivesTheSameBits) {
  const Scene scene = stress_scene(true);
  const Image first = sampled_of(scene, 7, 0);
  for (int i = 1; i < static_cast<int>(sampled_maths().count); ++i)
    EXPECT_EQ(sampled_of(scene, 7, i).rgba, first.rgba);
  AbufferOptions plain;
  plain.simd = false;
  EXPECT_EQ(render_abuffer(scene, plain)->image.rgba, exact_of(scene).rgba);
}

TEST(ChangingLooks, OrderOfPointsChangesNoBit) {
  Scene scene = stress_scene(true);
  const Image sampled = sampled_of(scene, 5), exact = exact_of(scene);
  SurfelCloud& cloud = scene.objects[0].cloud;
  for (SurfelKey& key : cloud.keys) {
    std::reverse(key.pose.position.begin(), key.pose.position.end());
    std::reverse(key.pose.axis_u.begin(), key.pose.axis_u.end());
    std::reverse(key.pose.axis_v.begin(), key.pose.axis_v.end());
  }
  for (LookKey& key : cloud.looks) {
    std::reverse(key.color.begin(), key.color.end());
    std::reverse(key.opacity.begin(), key.opacity.end());
  }
  EXPECT_EQ(sampled_of(scene, 5).rgba, sampled.rgba);
  EXPECT_EQ(exact_of(scene).rgba, exact.rgba);
}

TEST(ChangingLooks, LooksThatAreHeldAreNone) {
  Scene scene = stress_scene(true);
  SurfelCloud& cloud = scene.objects[0].cloud;
  cloud.looks = {cloud.looks[1], cloud.looks[2]};
  cloud.looks[0].frame = 3.0;
  cloud.looks[1].frame = 4.0;
  const Image sampled = sampled_of(scene, 5), exact = exact_of(scene);
  cloud.color = cloud.looks[0].color;
  cloud.opacity = cloud.looks[0].opacity;
  cloud.looks.clear();
  EXPECT_EQ(sampled_of(scene, 5).rgba, sampled.rgba);
  EXPECT_EQ(exact_of(scene).rgba, exact.rgba);
}

TEST(ChangingLooks, ValidationNamesTheLook) {
  const auto field_of = [](const SurfelCloud& cloud) {
    const Status status = cloud.validate();
    return status ? std::string() : status.error().field;
  };
  SurfelCloud cloud = wall(0.0).cloud;
  cloud.looks = {look(0.0, Vector3f::Ones(), 1.0f), look(1.0, Vector3f::Ones(), 1.0f)};
  EXPECT_EQ(field_of(cloud), "");
  cloud.looks[1].opacity[0] = 1.5f;
  EXPECT_EQ(field_of(cloud), "looks[1].opacity[0]");
  cloud.looks[1].opacity[0] = 1.0f;
  cloud.looks[1].color.push_back(Vector3f::Ones());
  EXPECT_EQ(field_of(cloud), "looks[1].color");
  cloud.looks[1].color.clear();
  cloud.looks[1].frame = 0.0;
  EXPECT_EQ(field_of(cloud), "looks[1].frame");
}

}  // namespace
}  // namespace swept
