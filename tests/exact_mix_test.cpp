// Moving triangles and discs in one exact exposure (model section 15.4): beside the engine that looks at many
// instants, the plain reference, and what can be told without either.
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/mesh_scenes.h"

namespace swept {
namespace {

using test::add_point;
using test::exact;
using test::psnr_db;

Image stills(const Scene& scene, int samples = 1024) { return test::sampled(scene, samples); }
Image reference(const Scene& scene, int samples = 1024) { return test::reference(scene, samples); }
Scene stage(int width = 40, int height = 30) { return test::mesh_stage(width, height, 30.0 / 64.0); }

Object rectangle(const Eigen::Vector3d& middle, double half_width, double half_height,
                 const Eigen::Vector3f& color, float opacity = 1.0f) {
  Object object = test::rectangle(middle, half_width, half_height, color);
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
  test::move_points(object, velocity);
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

/// A cloud whose discs all come nearer to the background, and a mesh among them.
Scene flight() {
  Scene scene = stage();
  scene.objects = {rectangle({0.1, 0.05, 3.0}, 0.8, 0.6, {0.2f, 0.4f, 1.0f}),
                   cloud(250, 3, {-0.1, 0, 2.5}, 0.6, 0.12f, {0.3f, 0.1f, 1.0f})};
  test::move_points(scene.objects[0], {-0.2f, 0.1f, 0.0f});
  return scene;
}

/// There and back again: keys.
Scene flight_and_back() {
  Scene scene = flight();
  SurfelCloud& flying = scene.objects[1].cloud;
  flying.velocity.clear();
  for (const double frame : {0.5, 1.0}) {
    SurfelKey key = flying.keys[0];
    key.frame = frame;
    if (frame == 0.5)
      for (Eigen::Vector3d& p : key.pose.position) p += Eigen::Vector3d(0.1, 0.05, 1.2);
    flying.keys.push_back(key);
  }
  return scene;
}

TEST(ExactMix, IsTheMeanOfManyInstants) {
  Scene scene = flight();
  // A segment has the pixel filter of its middle: what comes nearer needs several, with or without a mesh.
  scene.model.segments = 64;
  expect_the_mean(scene, "a cloud flies through a mesh");
  scene = flight_and_back();
  scene.model.segments = 64;
  expect_the_mean(scene, "a cloud flies through a mesh and back");

  scene.objects = {rectangle({0, 0, 3.0}, 0.8, 0.6, {0.2f, 0.4f, 1.0f}),
                   cloud(60, 4, {0, 0, 2.0}, 0.4, 0.15f, {0.4f, 0.0f, 0.0f}, 0.4f),
                   cloud(60, 5, {0, 0, 4.0}, 0.9, 0.3f, {-0.6f, 0.2f, 0.0f}, 0.6f)};
  test::move_points(scene.objects[0], {0.0f, 0.3f, 0.0f});
  expect_the_mean(scene, "translucent discs before and behind an opaque mesh");

  scene.objects[0] = rectangle({0, 0, 3.0}, 0.8, 0.6, {0.2f, 0.4f, 1.0f}, 0.5f);
  test::move_points(scene.objects[0], {0.2f, 0.3f, 0.0f});
  expect_the_mean(scene, "a translucent mesh between translucent discs");
}

/// As many segments as are made unasked: with the depth tolerance of each segment's middle these came to 58.9
/// and 54.1 dB, with its pixel filter to 69.0 and 64.9.
TEST(ExactMix, FliesThroughUnasked) {
  const auto db = [](const Scene& scene) {
    const Rendered rendered = exact(scene);
    const double found = psnr_db(rendered.image, stills(scene));
    std::printf("%.1f dB, %g kernels\n", found, test::counter(rendered, "kernels"));
    return found;
  };
  EXPECT_GE(db(flight()), 70.0);
  EXPECT_GE(db(flight_and_back()), 70.0);
}

TEST(ExactMix, IsTheMeanWhereNobodyChoseTheScene) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Scene scene = stage();
    scene.model.segments = 16;
    scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
    scene.objects = {
        test::triangle_soup(20, seed, seed % 2 == 0),
        cloud(80, seed, {0, 0, 3.0}, 1.2, 0.15f, {0.3f, -0.2f, 0.6f}, seed % 3 == 0 ? 0.5f : 1.0f)};
    if (seed % 3 == 1) scene.objects.push_back(test::triangle_soup(10, 100 + seed, true));
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
  test::move_points(disc, {0, 0, -1});
  scene.objects = {rectangle({0, 0, 2.0}, 3.0, 3.0, {1, 0, 0}), disc};
  test::move_points(scene.objects[0], {0, 0, 1});
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
  test::move_points(scene.objects[0], {-0.2f, 0.1f, 0.0f});
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
  scene.objects = {test::triangle_soup(20, 3, true),
                   cloud(150, 4, {0, 0, 3.0}, 1.2, 0.15f, {0.3f, -0.2f, 0.6f}, 0.7f),
                   test::triangle_soup(10, 5, false)};
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
  EXPECT_TRUE(test::is_crop_of(crop, first, scene.film));
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
