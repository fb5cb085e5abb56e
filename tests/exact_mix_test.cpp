// Moving triangles and discs in one exact exposure (model section 15.4): beside the engine that looks at many
// instants, the plain reference, and what can be told without either.
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "tests/counter.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using test::psnr_db;

Rendered exact(const Scene& scene, const AbufferOptions& options = {}, int threads = 0) {
  RenderControl control;
  control.threads = threads;
  Result<Rendered> result = render_abuffer(scene, options, control);
  EXPECT_TRUE(result.ok()) << result.error().message();
  if (!result.ok()) std::abort();
  return std::move(*result);
}

Image stills(const Scene& scene, int samples = 1024) {
  SampledOptions options;
  options.samples = samples;
  Result<Rendered> result = render_sampled(scene, options);
  EXPECT_TRUE(result.ok()) << result.error().message();
  if (!result.ok()) std::abort();
  return std::move(result->image);
}

Image reference(const Scene& scene, int samples = 1024) {
  Result<Rendered> result = render_reference(scene, {samples, ReferenceMotion::smooth});
  EXPECT_TRUE(result.ok()) << result.error().message();
  if (!result.ok()) std::abort();
  return std::move(result->image);
}

/// A camera at the origin that looks along z, y down, with a focal length of 64 px for 80 by 60 of them.
Scene stage(int width = 40, int height = 30) {
  Scene scene;
  scene.film = {width, height, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats = {test::looking_along_z(0.0, {0, 0, 0}, {0, 0, 1}, 60.0)};
  scene.camera.look_ats[0].tan_half_fov_y = 30.0 / 64.0;
  scene.camera.near = 0.1;
  return scene;
}

std::uint32_t add_point(Object& object, const Eigen::Vector3d& position, const Eigen::Vector3f& color,
                        float radius = 0.1f) {
  if (object.cloud.keys.empty()) object.cloud.keys.emplace_back();
  SurfelPose& pose = object.cloud.keys[0].pose;
  pose.position.push_back(position);
  pose.axis_u.emplace_back(radius, 0.0f, 0.0f);
  pose.axis_v.emplace_back(0.0f, radius, 0.0f);
  object.cloud.color.push_back(color);
  return static_cast<std::uint32_t>(pose.size() - 1);
}

void move(Object& object, const Eigen::Vector3f& velocity) {
  object.cloud.velocity.assign(object.cloud.size(), velocity);
}

Object rectangle(const Eigen::Vector3d& middle, double half_width, double half_height,
                 const Eigen::Vector3f& color, float opacity = 1.0f) {
  Object object;
  for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
    add_point(object, middle + Eigen::Vector3d(x * half_width, y * half_height, 0.0), color);
  object.triangles = {{0, 1, 2}, {0, 2, 3}};
  object.cloud.opacity.assign(4, opacity);
  return object;
}

/// Discs in a box, which move alike.
Object cloud(int points, unsigned seed, const Eigen::Vector3d& middle, double half, float radius,
             const Eigen::Vector3f& velocity, float opacity = 1.0f) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  Object object;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector3d offset(uniform(-half, half), uniform(-half, half), uniform(-half, half));
    add_point(object, middle + offset,
              {static_cast<float>(uniform(0, 1)), static_cast<float>(uniform(0, 1)), 0.3f}, radius);
  }
  object.cloud.opacity.assign(object.cloud.size(), opacity);
  move(object, velocity);
  return object;
}

/// Triangles at random, of many sizes.
Object soup(int triangles, unsigned seed, bool transparent, double speed = 0.5) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  Object object;
  for (int t = 0; t < triangles; ++t) {
    const Eigen::Vector3d middle(uniform(-2.0, 2.0), uniform(-1.5, 1.5), uniform(-0.2, 6.0));
    const double size = std::pow(10.0, uniform(-2.0, 0.3));
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d offset(uniform(-size, size), uniform(-size, size), uniform(-size, size));
      const auto channel = [&] { return static_cast<float>(uniform(0.0, 1.0)); };
      const auto rate = [&] { return static_cast<float>(uniform(-speed, speed)); };
      add_point(object, middle + offset, {channel(), channel(), channel()});
      object.cloud.velocity.emplace_back(rate(), rate(), rate());
      if (transparent) object.cloud.opacity.push_back(channel());
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    object.triangles.push_back({first, first + 1, first + 2});
  }
  return object;
}

void expect_the_mean(const Scene& scene, const char* name) {
  const Rendered rendered = exact(scene);
  EXPECT_GT(test::counter(rendered, "pixels_of_discs_and_triangles"), 20.0) << name;
  const double engine = psnr_db(rendered.image, stills(scene)),
               plain = psnr_db(rendered.image, reference(scene));
  Scene discs = scene;
  std::erase_if(discs.objects, [](const Object& o) { return !o.triangles.empty(); });
  const double alone = psnr_db(exact(discs).image, stills(discs));
  std::printf(
      "%s: %.1f dB from the engine's instants, %.1f dB from the reference's; its discs alone %.1f dB\n", name,
      engine, plain, alone);
  EXPECT_GT(engine, 70.0) << name;
  EXPECT_GT(plain, 70.0) << name;
}

TEST(ExactMix, IsTheMeanOfManyInstants) {
  Scene scene = stage();
  // A segment has the pixel filter of its middle: what comes nearer needs several, with or without a mesh.
  scene.model.segments = 64;
  scene.objects = {rectangle({0.1, 0.05, 3.0}, 0.8, 0.6, {0.2f, 0.4f, 1.0f}),
                   cloud(250, 3, {-0.1, 0, 2.5}, 0.6, 0.12f, {0.3f, 0.1f, 1.0f})};
  move(scene.objects[0], {-0.2f, 0.1f, 0.0f});
  expect_the_mean(scene, "a cloud flies through a mesh");

  // There and back again: keys.
  SurfelCloud& flying = scene.objects[1].cloud;
  flying.velocity.clear();
  for (const double frame : {0.5, 1.0}) {
    SurfelKey key = flying.keys[0];
    key.frame = frame;
    if (frame == 0.5)
      for (Eigen::Vector3d& p : key.pose.position) p += Eigen::Vector3d(0.1, 0.05, 1.2);
    flying.keys.push_back(key);
  }
  expect_the_mean(scene, "a cloud flies through a mesh and back");

  scene.objects = {rectangle({0, 0, 3.0}, 0.8, 0.6, {0.2f, 0.4f, 1.0f}),
                   cloud(60, 4, {0, 0, 2.0}, 0.4, 0.15f, {0.4f, 0.0f, 0.0f}, 0.4f),
                   cloud(60, 5, {0, 0, 4.0}, 0.9, 0.3f, {-0.6f, 0.2f, 0.0f}, 0.6f)};
  move(scene.objects[0], {0.0f, 0.3f, 0.0f});
  expect_the_mean(scene, "translucent discs before and behind an opaque mesh");

  scene.objects[0] = rectangle({0, 0, 3.0}, 0.8, 0.6, {0.2f, 0.4f, 1.0f}, 0.5f);
  move(scene.objects[0], {0.2f, 0.3f, 0.0f});
  expect_the_mean(scene, "a translucent mesh between translucent discs");
}

TEST(ExactMix, IsTheMeanWhereNobodyChoseTheScene) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Scene scene = stage();
    scene.model.segments = 16;
    scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
    scene.objects = {soup(20, seed, seed % 2 == 0), cloud(80, seed, {0, 0, 3.0}, 1.2, 0.15f,
                                                          {0.3f, -0.2f, 0.6f}, seed % 3 == 0 ? 0.5f : 1.0f)};
    if (seed % 3 == 1) scene.objects.push_back(soup(10, 100 + seed, true));
    if (seed == 5) scene.model.depth_tolerance = 0.0;
    if (seed == 6) scene.model.coverage = Coverage::hard;
    expect_the_mean(scene, ("seed " + std::to_string(seed)).c_str());
  }
}

/// Rönnow et al. 2021, Fig. 11, with a large disc for one of the two.
TEST(ExactMix, CrossingInDepthGivesHalfAndHalf) {
  Scene scene = stage(20, 16);
  Object disc;
  add_point(disc, {0, 0, 3.0}, {0, 0, 1}, 100.0f);
  move(disc, {0, 0, -1});
  scene.objects = {rectangle({0, 0, 2.0}, 3.0, 3.0, {1, 0, 0}), disc};
  move(scene.objects[0], {0, 0, 1});
  const Image image = exact(scene).image;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    ASSERT_NEAR(image.rgba[4 * i], 0.5, 1e-6);
    ASSERT_NEAR(image.rgba[4 * i + 2], 0.5, 1e-6);
    ASSERT_NEAR(image.rgba[4 * i + 3], 1.0, 1e-6);
  }
}

TEST(ExactMix, FollowsShuttersAndRows) {
  Scene scene = stage();
  scene.objects = {rectangle({0.1, 0.05, 3.0}, 0.8, 0.6, {0.2f, 0.4f, 1.0f}),
                   cloud(100, 3, {-0.1, 0, 2.5}, 0.6, 0.12f, {0.3f, 0.1f, 0.0f})};
  move(scene.objects[0], {-0.2f, 0.1f, 0.0f});
  scene.shutter.curve = ShutterShape::trapezoid;
  EXPECT_GT(psnr_db(exact(scene).image, stills(scene)), 70.0);
  scene.shutter.curve = ShutterShape::box;
  scene.shutter.row_delay = 0.01;
  const Image rolled = exact(scene).image;
  Scene row = scene;
  row.shutter.row_delay = 0.0;
  row.film.crop_width = scene.film.width, row.film.crop_height = 1;
  for (const int y : {3, 12, 17, 22}) {
    row.film.crop_y = y;
    row.shutter.open = scene.shutter.open + 0.01 * y;
    row.shutter.close = scene.shutter.close + 0.01 * y;
    const Image alone = exact(row).image;
    for (std::size_t i = 0; i < alone.rgba.size(); ++i)
      ASSERT_NEAR(rolled.rgba[static_cast<std::size_t>(4 * y * scene.film.width) + i], alone.rgba[i], 1e-5)
          << y;
  }
}

TEST(ExactMix, HasTheSameBitsHoweverItIsDrawn) {
  Scene scene = stage(60, 50);
  scene.objects = {soup(20, 3, true), cloud(150, 4, {0, 0, 3.0}, 1.2, 0.15f, {0.3f, -0.2f, 0.6f}, 0.7f),
                   soup(10, 5, false)};
  const Image first = exact(scene).image;
  AbufferOptions options;
  options.tile_px = 7;
  options.tile_fragments = 300;
  EXPECT_EQ(exact(scene, options, 1).image.rgba, first.rgba);
  std::swap(scene.objects[0], scene.objects[2]);
  EXPECT_EQ(exact(scene).image.rgba, first.rgba);
  std::swap(scene.objects[0], scene.objects[1]);
  EXPECT_EQ(exact(scene).image.rgba, first.rgba);
  scene.film.crop_x = 10, scene.film.crop_y = 8, scene.film.crop_width = 30, scene.film.crop_height = 33;
  const Image crop = exact(scene).image;
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x)
      for (std::size_t c = 0; c < 4; ++c)
        ASSERT_EQ(crop.rgba[4 * static_cast<std::size_t>(y * crop.width + x) + c],
                  first.rgba[4 * static_cast<std::size_t>((y + 8) * first.width + x + 10) + c]);
}

/// Where nothing moves one instant is all there is.
TEST(ExactMix, StandsStillAsTheEngineHasIt) {
  Scene scene = stage();
  scene.objects = {rectangle({0, 0, 3.0}, 0.8, 0.6, {0.2f, 0.4f, 1.0f}),
                   cloud(100, 3, {0, 0, 2.5}, 0.6, 0.12f, {0, 0, 0})};
  EXPECT_EQ(exact(scene).image.rgba, stills(scene, 1).rgba);
}

}  // namespace
}  // namespace swept
