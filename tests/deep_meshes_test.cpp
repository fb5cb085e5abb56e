// Samples by depth of triangles (model section 19): they flatten to the picture, and say what is where.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/deep_image.h"
#include "tests/deep_flattened.h"
#include "tests/drawn.h"
#include "tests/mesh_scenes.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

Rendered deep(const Scene& scene, int threads = 0) {
  RenderControl control;
  control.threads = threads;
  return test::render_deep(scene, {}, control);
}

constexpr double rounding = test::deep_rounding;

/// The most by which R, G, B or A, front over back, is off from the picture.
double flattened_error(const Scene& scene, bool moves = true) {
  const Rendered taken_apart = deep(scene);
  const Image& picture = taken_apart.image;
  // It does not depend on what else is asked for; a still is the engine's otherwise, which counts in floats.
  const Image alone = test::exact(scene).image;
  if (moves) {
    EXPECT_EQ(picture.rgba, alone.rgba);
  }
  for (std::size_t i = 0; i < picture.rgba.size(); ++i) EXPECT_NEAR(picture.rgba[i], alone.rgba[i], 2e-4f);
  return test::flattened_error(*taken_apart.deep, picture);
}

/// Alpha of all that begins nearer than `depth`.
double alpha_before(const DeepImage& samples, std::size_t pixel, float depth) {
  double left = 1.0;
  for (std::size_t i = samples.first[pixel]; i < samples.first[pixel + 1]; ++i)
    if (samples.depth[2 * i] < depth) left *= 1.0 - double{samples.rgba[4 * i + 3]};
  return 1.0 - left;
}

TEST(DeepMeshes, FlattenToThePicture) {
  Scene scene = test::mesh_stage(40, 30, 0.6);
  scene.objects = {test::triangle_soup(60, 1, false)};
  EXPECT_LT(flattened_error(scene), rounding) << "one mesh";
  scene.objects.push_back(test::triangle_soup(40, 2, true));
  scene.background = {0.25f, 0.5f, 0.125f, 0.75f};
  EXPECT_LT(flattened_error(scene), rounding) << "two, one of them see-through, and a background";
  Object discs;
  test::Random random(3);
  for (int i = 0; i < 30; ++i)
    test::add_point(discs, {random(-1, 1), random(-1, 1), random(1, 5)}, {0.2f, 0.9f, 0.4f}, 0.3f);
  discs.cloud.opacity.assign(discs.cloud.size(), 0.7f);
  test::move_points(discs, {0.5f, 0.1f, 0.7f});
  scene.objects.push_back(discs);
  EXPECT_LT(flattened_error(scene), rounding) << "and discs";
}

TEST(DeepMeshes, FlattenWhateverTheExposureIs) {
  Scene scene = test::mesh_stage(24, 18, 0.6);
  scene.objects = {test::triangle_soup(30, 5, true), test::triangle_soup(30, 6, false)};
  Scene curve = scene;
  curve.shutter.curve = ShutterShape::gaussian;
  EXPECT_LT(flattened_error(curve), rounding) << "a curve";
  Scene rolling = scene;
  rolling.shutter.row_delay = 0.01;
  EXPECT_LT(flattened_error(rolling), rounding) << "a rolling shutter";
  Scene instant = scene;
  instant.shutter.close = instant.shutter.open;
  EXPECT_LT(flattened_error(instant, false), rounding) << "an instant";
  Scene still = scene;
  for (Object& object : still.objects) object.cloud.velocity.clear();
  EXPECT_LT(flattened_error(still, false), rounding) << "nothing moves";
  Scene lens = scene;
  lens.camera.aperture.radius = 0.05;
  lens.camera.aperture.samples = 5;
  for (LookAtKey& key : lens.camera.look_ats) key.lens.focus = 3.0;
  EXPECT_LT(flattened_error(lens), rounding) << "a lens";
  Scene turning = scene;
  TransformKey a, b;
  a.rotate_axis = b.rotate_axis = Eigen::Vector3d::UnitZ();
  b.frame = 1.0;
  b.rotate_radians = 1.0;
  for (Object& object : turning.objects) object.transform.keys = {a, b};
  EXPECT_LT(flattened_error(turning), rounding) << "curved paths";
}

TEST(DeepMeshes, LieEvenlyAlongTheirWay) {
  // A wall that comes from 8 to 4: at 8 − 4τ, so half of it is nearer than 6.
  Scene scene = test::mesh_stage(8, 6, 0.5);
  scene.objects = {test::rectangle({0, 0, 8}, 99, 99, {1, 0.5f, 0.25f})};
  test::move_points(scene.objects[0], {0, 0, -4});
  const Rendered one = deep(scene);
  // And the same of two meshes, of which the other is behind.
  scene.objects.push_back(test::rectangle({0, 0, 20}, 99, 99, {0, 0, 1}));
  const Rendered two = deep(scene);
  for (const Rendered* rendered : {&one, &two})
    for (const std::size_t pixel : {std::size_t{0}, std::size_t{27}}) {
      const DeepImage& samples = *rendered->deep;
      EXPECT_NEAR(double{samples.depth[2 * samples.first[pixel]]}, 4.0, 1e-5);
      EXPECT_NEAR(double{samples.depth[2 * samples.first[pixel + 1] - 1]}, 8.0, 1e-5);
      for (const float depth : {5.0f, 6.0f, 7.0f})
        EXPECT_NEAR(alpha_before(samples, pixel, depth), (double{depth} - 4.0) / 4.0, 0.01) << depth;
      EXPECT_NEAR(alpha_before(samples, pixel, 9.0f), 1.0, 1e-6);
    }
}

TEST(DeepMeshes, AVeilOfTrianglesStandsBeforeWhatItVeils) {
  // Half of its light is the veil's at 2, the rest the disc's at 3 and the wall's at 4.
  Scene scene = test::mesh_stage(8, 6, 0.5);
  Object veil = test::rectangle({0, 0, 2}, 99, 99, {1, 0, 0});
  veil.cloud.opacity.assign(4, 0.5f);
  test::move_points(veil, {0.1f, 0, 0});
  Object disc;
  test::add_point(disc, {0, 0, 3}, {0, 1, 0}, 99.0f);
  disc.cloud.opacity = {0.5f};
  scene.objects = {veil, disc, test::rectangle({0, 0, 4}, 99, 99, {0, 0, 1})};
  const DeepImage samples = *deep(scene).deep;
  for (std::size_t pixel = 0; pixel < samples.pixel_count(); ++pixel) {
    ASSERT_EQ(samples.first[pixel + 1] - samples.first[pixel], 3u);
    const std::size_t i = samples.first[pixel];
    EXPECT_NEAR(double{samples.rgba[4 * i]}, 0.5, 1e-6);
    EXPECT_NEAR(double{samples.rgba[4 * (i + 1) + 1]}, 0.5, 1e-6);
    EXPECT_NEAR(double{samples.rgba[4 * (i + 2) + 2]}, 1.0, 1e-5);
    EXPECT_NEAR(double{samples.depth[2 * i]}, 2.0, 1e-5);
    EXPECT_NEAR(double{samples.depth[2 * i + 2]}, 3.0, 1e-5);
    EXPECT_NEAR(double{samples.depth[2 * i + 4]}, 4.0, 1e-5);
  }
}

TEST(DeepMeshes, AreTheSameForAnyThreadsAndTiles) {
  Scene scene = test::mesh_stage(40, 30, 0.6);
  scene.objects = {test::triangle_soup(60, 1, true), test::triangle_soup(60, 2, false)};
  const DeepImage whole = *deep(scene).deep, one = *deep(scene, 1).deep;
  EXPECT_EQ(whole.rgba, one.rgba);
  EXPECT_EQ(whole.depth, one.depth);
  Scene crop = scene;
  crop.film.crop_x = 11, crop.film.crop_y = 7, crop.film.crop_width = 9, crop.film.crop_height = 12;
  const DeepImage part = *deep(crop).deep;
  for (std::size_t y = 0; y < 12; ++y)
    for (std::size_t x = 0; x < 9; ++x) {
      const std::size_t a = part.first[y * 9 + x], b = whole.first[(y + 7) * 40 + x + 11];
      const std::size_t count = part.first[y * 9 + x + 1] - a;
      ASSERT_EQ(count, whole.first[(y + 7) * 40 + x + 12] - b);
      for (std::size_t k = 0; k < 4 * count; ++k) ASSERT_EQ(part.rgba[4 * a + k], whole.rgba[4 * b + k]);
    }
}

}  // namespace
}  // namespace swept
