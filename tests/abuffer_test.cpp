// The A-buffer as a whole: what must not change a bit, and agreement with the reference.
#include "abuffer/abuffer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <span>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/reference/reference.h"
#include "tests/counter.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using test::add_disc;
using test::busy_scene;
using test::checkered_sphere;
using test::counter;
using test::move;
using test::Random;
using test::stage;

Scene particles() {
  Scene scene = stage();
  Random random(5);
  Object object;
  object.cloud.keys.resize(1);
  for (int i = 0; i < 1500; ++i) {
    const Vector3d normal(random(-1, 1), random(-1, 1), random(-1, 1));
    add_disc(object, {random(-2, 2), random(-2, 2), random(-2, 2)}, normal.normalized(), random(0.01, 0.08),
             Eigen::Vector3d(random(0, 1), random(0, 1), random(0, 1)).cast<float>());
    object.cloud.velocity.push_back(Vector3d(random(-1, 1), random(-1, 1), random(-1, 1)).cast<float>());
    object.cloud.opacity.push_back(static_cast<float>(random(0.3, 1.0)));
  }
  scene.objects = {object};
  return scene;
}

/// Discs fly past the camera, through the near plane and through the eye.
Scene fly_past() {
  Scene scene = stage();
  scene.camera.near = 0.05;
  Object object;
  object.cloud.keys.resize(1);
  Random random(9);
  for (int i = 0; i < 60; ++i) {
    const Vector3d normal(random(-1, 1), random(-1, 1), random(-1, 1));
    add_disc(object, {random(-0.5, 0.5), random(-0.5, 0.5), random(3.0, 4.8)}, normal.normalized(), 0.15,
             Eigen::Vector3d(random(0, 1), random(0, 1), random(0, 1)).cast<float>());
  }
  add_disc(object, {0.0, 0.0, 4.0}, Vector3d(0.0, 0.1, 1.0).normalized(), 0.4, {1.0f, 1.0f, 1.0f});
  object.cloud.velocity.assign(object.cloud.size(), Eigen::Vector3f(0.0f, 0.0f, 2.0f));
  scene.objects = {object};
  return scene;
}

Image render(const Scene& scene, const AbufferOptions& options = {}, const RenderControl& control = {}) {
  auto rendered = render_abuffer(scene, options, control);
  EXPECT_TRUE(rendered.ok()) << rendered.error().message();
  return std::move(rendered).value().image;
}

bool same_bits(std::span<const float> a, std::span<const float> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}
bool same_bits(const Image& a, const Image& b) {
  return same_bits(a.rgba, b.rgba) && same_bits(a.depth, b.depth);
}

double rmse(const Image& a, const Image& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    sum += std::pow(static_cast<double>(a.rgba[i]) - static_cast<double>(b.rgba[i]), 2);
  return std::sqrt(sum / static_cast<double>(a.rgba.size()));
}

/// 80 dB, on top of what the reference is off by itself. Its estimate is of RGB and within a factor of √1.5.
/// Of chords, along which the reference goes too; parabolas are nearer to the true path.
void expect_agreement(const Scene& scene, int samples) {
  auto reference = render_reference(scene, {samples, ReferenceMotion::segments});
  ASSERT_TRUE(reference.ok()) << reference.error().message();
  const double own = counter(*reference, "reference_error_rmse");
  const Image chords = render(scene, {.parabolas = false}), parabolas = render(scene);
  EXPECT_LT(rmse(chords, reference->image), std::hypot(1e-4, 1.5 * own)) << "the reference is off by " << own;
  EXPECT_LT(own, 4e-4) << "the reference is too coarse to judge";
  if (same_bits(chords, parabolas)) return;
  auto truth = render_reference(scene, {samples, ReferenceMotion::smooth});
  ASSERT_TRUE(truth.ok()) << truth.error().message();
  EXPECT_LT(rmse(parabolas, truth->image), std::hypot(1e-4, rmse(chords, truth->image)));
}

TEST(Abuffer, AgreesWithTheReferenceWhereSurfacesCross) { expect_agreement(busy_scene(), 512); }
TEST(Abuffer, AgreesWithTheReferenceOnTranslucentParticles) { expect_agreement(particles(), 1024); }
TEST(Abuffer, AgreesWithTheReferenceThroughTheNearPlane) { expect_agreement(fly_past(), 1024); }

TEST(Abuffer, AgreesWithTheReferenceUnderHardCoverage) {
  Scene scene = busy_scene();
  scene.model.coverage = Coverage::hard;
  expect_agreement(scene, 1024);
}

/// Small dark discs that hardly move and a few large bright ones that do, all in one surface: as long as one
/// of these passes, colour and weight rise and fall together.
TEST(Abuffer, AgreesWithTheReferenceWhereFewOfManyMove) {
  Scene scene = stage();
  scene.film = {24, 18, 0, 0, 0, 0};
  scene.model.coverage = Coverage::hard;
  scene.model.delta = 15.0;
  scene.model.depth_tolerance = 15.0;
  scene.model.filter_radius_px = 12.0;
  Random random(3);
  Object& dark = scene.objects.emplace_back();
  for (int i = 0; i < 60; ++i)
    add_disc(dark, random.vector(-1.2, 1.2), Vector3d::UnitZ(), 0.02, {0.0f, 0.1f, 0.1f});
  dark.cloud.velocity.assign(60, {0.01f, 0.0f, 0.0f});
  Object& bright = scene.objects.emplace_back();
  for (int i = 0; i < 4; ++i) add_disc(bright, random.vector(-1.2, 1.2), Vector3d::UnitZ(), 0.2);
  bright.cloud.velocity.assign(4, {8.0f, 5.0f, 0.0f});
  expect_agreement(scene, 1024);
}

TEST(Abuffer, AgreesWithTheReferenceOnOneSidedSurfaces) {
  Scene scene = busy_scene();
  for (Object& object : scene.objects) object.two_sided = false;
  expect_agreement(scene, 512);
}

TEST(Abuffer, ThreadsAndTilesChangeNoBit) {
  for (const Scene& scene : {busy_scene(), particles()}) {
    const Image image = render(scene, {}, {.threads = 1});
    EXPECT_TRUE(same_bits(image, render(scene, {}, {.threads = 2})));
    EXPECT_TRUE(same_bits(image, render(scene, {.tile_px = 7})));
    EXPECT_TRUE(same_bits(image, render(scene, {.tile_px = 4096})));
    EXPECT_TRUE(same_bits(image, render(scene, {.tile_fragments = 100})));
    EXPECT_TRUE(same_bits(image, render(scene, {.tile_fragments = 1})));
  }
}

TEST(Abuffer, NormalisationPerPixelChangesColoursOnlyAndOnlyWhereTheyChange) {
  const AbufferOptions per_pixel{.normalisation = Normalisation::pixel};
  for (const Coverage coverage : {Coverage::soft, Coverage::hard}) {
    Scene scene = busy_scene();
    scene.model.coverage = coverage;
    const Image interval = render(scene), pixel = render(scene, per_pixel);
    EXPECT_TRUE(same_bits(interval.depth, pixel.depth));
    float most = 0.0f;
    for (std::size_t i = 0; i < interval.rgba.size(); ++i) {
      if (i % 4 == 3) {
        ASSERT_EQ(interval.rgba[i], pixel.rgba[i]);
      }
      most = std::max(most, std::abs(interval.rgba[i] - pixel.rgba[i]));
    }
    EXPECT_GT(most, 0.01f) << "the case does not tell";
    EXPECT_TRUE(same_bits(pixel, render(scene, {.tile_px = 7, .normalisation = Normalisation::pixel})));

    // One colour is what it is however it is weighted; and a front that stands still keeps its weights.
    Scene one_color = stage(), still = stage();
    one_color.model.coverage = still.model.coverage = coverage;
    one_color.objects = {checkered_sphere(0.8, 900)};
    move(one_color.objects[0], {-0.6, -0.2, 0.3}, {0.5, 0.2, -0.3}, 0.5);
    for (Eigen::Vector3f& color : one_color.objects[0].cloud.color) color = {0.75f, 0.5f, 0.25f};
    Random random(3);
    Object sheet;
    sheet.cloud.keys.resize(1);
    for (int i = 0; i < 800; ++i)
      add_disc(sheet, {random(-1.5, 1.5), random(-1, 1), 0.0}, {0.0, 0.0, 1.0}, 0.1,
               Eigen::Vector3d(random(0, 1), random(0, 1), random(0, 1)).cast<float>());
    still.objects = {sheet};
    for (const Scene& same : {one_color, still}) {
      const Image a = render(same), b = render(same, per_pixel);
      // Sums of up to some 50 kernels, in floats: 50 roundings on either way.
      for (std::size_t i = 0; i < a.rgba.size(); ++i) ASSERT_NEAR(a.rgba[i], b.rgba[i], 100 * 0x1p-24) << i;
    }
  }
}

TEST(Abuffer, OrderOfPointsAndObjectsChangesNoBit) {
  Scene scene = particles();
  scene.objects.push_back(checkered_sphere(0.4, 200));
  // Coincident points of different colours, too.
  Object& cloud = scene.objects[0];
  SurfelPose& pose = cloud.cloud.keys.front().pose;
  for (std::size_t i = 0; i < 100; ++i) {
    pose.position[i + 100] = pose.position[i];
    pose.axis_u[i + 100] = pose.axis_u[i];
    pose.axis_v[i + 100] = pose.axis_v[i];
    cloud.cloud.velocity[i + 100] = cloud.cloud.velocity[i];
  }
  const Image image = render(scene);

  std::vector<std::size_t> order(cloud.cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  const SurfelCloud original = cloud.cloud;
  for (std::size_t i = 0; i < order.size(); ++i) {
    pose.position[i] = original.keys[0].pose.position[order[i]];
    pose.axis_u[i] = original.keys[0].pose.axis_u[order[i]];
    pose.axis_v[i] = original.keys[0].pose.axis_v[order[i]];
    cloud.cloud.velocity[i] = original.velocity[order[i]];
    cloud.cloud.color[i] = original.color[order[i]];
    cloud.cloud.opacity[i] = original.opacity[order[i]];
  }
  std::swap(scene.objects[0], scene.objects[1]);
  EXPECT_TRUE(same_bits(image, render(scene)));
}

TEST(Abuffer, CropEqualsThosePixelsOfTheFrame) {
  Scene scene = busy_scene();
  const Image full = render(scene);
  scene.film.crop_x = 13;
  scene.film.crop_y = 9;
  scene.film.crop_width = 31;
  scene.film.crop_height = 22;
  const Image crop = render(scene);
  ASSERT_EQ(crop.width, 31);
  EXPECT_TRUE(test::is_crop_of(crop, full, scene.film));
}

TEST(Abuffer, WhatDoesNotMoveIsTheStillImageBitForBit) {
  Scene scene = busy_scene();
  for (Object& object : scene.objects) object.transform.keys.resize(1);
  auto open = render_abuffer(scene);
  ASSERT_TRUE(open.ok());
  EXPECT_EQ(counter(*open, "pixels_swept"), 0.0);
  EXPECT_EQ(counter(*open, "intervals"), 0.0);
  EXPECT_GT(counter(*open, "pixels_still"), 0.0);
  scene.shutter = {0.5, 0.5};
  EXPECT_TRUE(same_bits(open->image, render(scene)));
}

TEST(Abuffer, ClosedShutterIsTheStillImageOfThatInstant) {
  Scene scene = busy_scene();
  scene.shutter = {0.25, 0.25};
  auto closed = render_abuffer(scene);
  ASSERT_TRUE(closed.ok());
  EXPECT_EQ(counter(*closed, "pixels_swept"), 0.0);
  // The reference takes one still image then: what is left is float against double.
  auto reference = render_reference(scene, {});
  ASSERT_TRUE(reference.ok());
  EXPECT_LT(rmse(closed->image, reference->image), 1e-5);
}

TEST(Abuffer, StillPixelsOfAMovingSceneKeepTheStillBits) {
  Scene scene = stage();
  scene.objects = {checkered_sphere(0.8, 900), checkered_sphere(0.3, 200)};
  move(scene.objects[0], {-0.8, 0.0, 0.0}, {-0.8, 0.0, 0.0});
  move(scene.objects[1], {1.2, 0.0, 0.0}, {1.6, 0.4, 0.0});
  const Image blurred = render(scene);
  scene.shutter = {0.5, 0.5};
  const Image still = render(scene);
  std::size_t seen = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 30; ++x) {
      const std::size_t i = static_cast<std::size_t>(y * 64 + x);
      seen += still.rgba[4 * i + 3] > 0.0f;
      EXPECT_TRUE(
          same_bits(std::span(blurred.rgba).subspan(4 * i, 4), std::span(still.rgba).subspan(4 * i, 4)))
          << x << ", " << y;
    }
  EXPECT_GT(seen, 200u);
}

TEST(Abuffer, LinearMotionDoesNotDependOnItsSegments) {
  Scene scene = stage();
  scene.objects = {checkered_sphere(0.8, 900)};
  move(scene.objects[0], {-0.6, -0.3, 0.0}, {0.6, 0.2, 0.0});
  // No perspective changes along this path but the pixel filter, which is that of a segment's middle. It sees
  // the discs from up to 0.12 rad aside of where they are at the ends: far less than a thousandth of what it
  // adds.
  const Image one = render(scene);
  scene.model.segments = 8;
  EXPECT_LT(rmse(one, render(scene)), 1e-3);
}

TEST(Abuffer, EmptyScenesAreBackground) {
  Scene scene = stage();
  scene.background = Eigen::Vector4f(0.1f, 0.2f, 0.3f, 0.5f);
  const Image image = render(scene);
  EXPECT_EQ(image.rgba[0], 0.1f);
  EXPECT_EQ(image.rgba[4 * 1000 + 3], 0.5f);
  EXPECT_TRUE(std::isinf(image.depth[0]));
}

TEST(Abuffer, RefusesOptionsOutOfRange) {
  for (const AbufferOptions& bad : {AbufferOptions{.tile_px = 0}, AbufferOptions{.tile_fragments = 0}}) {
    auto rendered = render_abuffer(stage(), bad);
    ASSERT_FALSE(rendered.ok());
    EXPECT_FALSE(rendered.error().field.empty());
  }
  auto rendered = render_abuffer(stage(), {}, {.threads = -1});
  ASSERT_FALSE(rendered.ok());
  EXPECT_EQ(rendered.error().field, "threads");
}

/// From within, as soon as there is any progress.
template <class Render>
void expect_progress_and_stop(const Render& render) {
  double told = 0.0;
  RenderControl watched;
  watched.progress = [&](double share) {
    EXPECT_GE(share, told);
    told = share;
  };
  EXPECT_TRUE(render(watched).ok());
  EXPECT_EQ(told, 1.0);
  std::stop_source source;
  RenderControl stopped;
  stopped.stop = source.get_token();
  stopped.progress = [&](double) { source.request_stop(); };
  const auto rendered = render(stopped);
  ASSERT_FALSE(rendered.ok());
  EXPECT_EQ(rendered.error().reason, "the render was stopped");
}

TEST(Abuffer, TellsItsProgressAndStopsWhenAsked) {
  expect_progress_and_stop(
      [](const RenderControl& control) { return render_abuffer(busy_scene(), {.tile_px = 16}, control); });
  expect_progress_and_stop([](const RenderControl& control) {
    return render_reference(busy_scene(), {4, ReferenceMotion::smooth}, control);
  });
}

/// What it keeps of what moves is known to the byte; a byte less is too little.
TEST(Abuffer, ObeysMaxBytes) {
  Scene scene = particles();
  for (const bool triangles : {false, true}) {
    if (triangles) {
      Object sheet = checkered_sphere(0.5, 300);
      for (std::uint32_t i = 0; i + 2 < sheet.cloud.size(); ++i) sheet.triangles.push_back({i, i + 1, i + 2});
      scene.objects.push_back(sheet);
    }
    const Result<Rendered> all = render_abuffer(scene);
    ASSERT_TRUE(all.ok()) << all.error().message();
    const auto bytes = static_cast<std::size_t>(counter(*all, "kept_bytes"));
    EXPECT_GT(bytes, 1000u);
    RenderControl control;
    control.max_bytes = bytes;
    EXPECT_TRUE(render_abuffer(scene, {}, control).ok());
    for (const std::size_t little : {bytes - 1, std::size_t{1}}) {
      control.max_bytes = little;
      const Result<Rendered> refused = render_abuffer(scene, {}, control);
      ASSERT_FALSE(refused.ok()) << little;
      EXPECT_EQ(refused.error().field, "max_bytes");
      EXPECT_EQ(refused.error().kind, ErrorKind::out_of_memory);
    }
  }
}

TEST(Abuffer, TheReferenceObeysMaxBytes) {
  const Scene scene = busy_scene();
  for (const ReferenceMotion motion : {ReferenceMotion::smooth, ReferenceMotion::segments}) {
    RenderControl control;
    control.max_bytes = 1000;
    const Result<Rendered> refused = render_reference(scene, {.samples = 2, .motion = motion}, control);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "max_bytes");
    EXPECT_EQ(refused.error().kind, ErrorKind::out_of_memory);
    control.max_bytes = 1 << 24;
    EXPECT_TRUE(render_reference(scene, {.samples = 2, .motion = motion}, control).ok());
  }
}

}  // namespace
}  // namespace swept
