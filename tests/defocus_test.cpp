// Depth of field by a thin lens: the shape of what is out of focus in closed form, and the same picture from
// every method.
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "splat/lens_points.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using test::decibels, test::reference, test::sampled;

Image exact(const Scene& scene) { return test::exact(scene).image; }
void open_lens(Scene& scene, double diameter, double focus, int samples, int blades = 0) {
  scene.camera.aperture = {0.5 * diameter, blades, 0.0, samples};
  for (LookAtKey& key : scene.camera.look_ats) key.lens.focus = focus;
}

/// Sums over the film of a lone light: how much there is, where its middle is, and its mean squared distance
/// from there, px.
struct Moments {
  double total = 0.0, x = 0.0, y = 0.0, spread = 0.0;

  explicit Moments(const Image& image) {
    for (int pass = 0; pass < 2; ++pass) {
      for (int j = 0; j < image.height; ++j)
        for (int i = 0; i < image.width; ++i) {
          const double alpha = image.rgba[4 * static_cast<std::size_t>(j * image.width + i) + 3];
          if (pass == 0) {
            total += alpha, x += alpha * i, y += alpha * j;
          } else {
            spread += alpha * ((i - x) * (i - x) + (j - y) * (j - y)) / total;
          }
        }
      if (pass == 0) x /= total, y /= total;
    }
  }
};

/// A speck 8 before the eye, far smaller than a pixel, so that what it adds is linear.
Scene speck() {
  Scene scene = test::stage();
  Object object;
  test::add_disc(object, {0, 0, -3}, {0, 0, 1}, 0.01);
  scene.objects = {object};
  return scene;
}

constexpr double focal_px = 48.0;  // of the stage: 48 px of height to tan ½

TEST(Defocus, APointHasTheLensesShape) {
  // The speck itself, convolved with the pixel filter: a Gaussian cut off at its radius, of which soft
  // coverage doubles what there is.
  const double own = 0.01 * focal_px / 8.0, square = 1.0 + own * own, cut = std::exp(-3.0);
  const double total = 2.0 * (own * own / square) * std::numbers::pi * square * (1.0 - cut) / 3.0;
  const double spread = square * (1.0 / 3.0 - cut / (1.0 - cut));
  const double middle_x = 31.5, middle_y = 23.5;
  for (const int blades : {0, 3, 5, 6}) {
    Scene scene = speck();
    open_lens(scene, 1.0, 4.0, 4096, blades);
    const double radius = 0.5 * circle_of_confusion_px(1.0, focal_px, 4.0, 8.0);
    ASSERT_NEAR(radius, 0.5 * 48.0 * (1.0 / 4.0 - 1.0 / 8.0), 1e-12);
    const Image image = sampled(scene, 1);
    const Moments blurred(image);
    EXPECT_NEAR(blurred.total, total, 2e-3 * total) << blades;
    EXPECT_NEAR(blurred.x, middle_x, 0.02) << blades;
    EXPECT_NEAR(blurred.y, middle_y, 0.02) << blades;
    // Mean squared radius: R²/2 of a disc, R²(2 + cos 2π/n)/6 of a polygon.
    const double shape = blades == 0 ? 0.5 : (2.0 + std::cos(2.0 * std::numbers::pi / blades)) / 6.0;
    // Of 4096 points spread evenly at random 1/√(12 · 4096) would be due; these do better.
    EXPECT_NEAR(blurred.spread - spread, shape * radius * radius, 4e-3 * radius * radius) << blades;
    if (blades != 0) continue;
    // Even within, nothing beyond, but for the width of a pixel: 4096 points are 0.08 px apart.
    const double even = total / (std::numbers::pi * radius * radius);
    for (int j = 0; j < image.height; ++j)
      for (int i = 0; i < image.width; ++i) {
        const double distance = std::hypot(i - middle_x, j - middle_y);
        const double alpha = image.rgba[4 * static_cast<std::size_t>(j * image.width + i) + 3];
        if (distance < radius - 1.1) {
          EXPECT_NEAR(alpha, even, 0.03 * even) << i << ' ' << j;
        } else if (distance > radius + 1.1) {
          EXPECT_EQ(alpha, 0.0) << i << ' ' << j;
        }
      }
  }
}

TEST(Defocus, WhatIsInFocusStaysSharp) {
  Scene scene = test::stage();
  Object object;
  test::Random random(3);
  for (int i = 0; i < 60; ++i)
    test::add_disc(object, {random(-2.0, 2.0), random(-1.5, 1.5), 0.0}, {0, 0, 1}, random(0.1, 0.4),
                   random.vector(0.0, 1.0).cast<float>());
  scene.objects = {object};
  const Image sharp = sampled(scene, 1);
  open_lens(scene, 0.8, 5.0, 32);
  EXPECT_GE(decibels(sampled(scene, 1), sharp), 90.0);
  // Focused elsewhere it is blurred.
  open_lens(scene, 0.8, 3.0, 32);
  EXPECT_LE(decibels(sampled(scene, 1), sharp), 35.0);
}

/// Two balls near and far of the focus, one of them fast, before a wall; a transparent one among them.
Scene still_life(bool moves) {
  Scene scene = test::stage();
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  scene.objects = {test::checkered_sphere(0.5, 300), test::checkered_sphere(0.6, 300),
                   test::checkered_sphere(0.4, 200)};
  scene.objects[2].cloud.opacity.assign(200, 0.6f);
  test::move(scene.objects[0], {-0.9, 0.1, 1.5}, {-0.9, 0.1, 1.5});
  test::move(scene.objects[1], {0.8, 0.0, -2.0}, {0.8, 0.0, -2.0});
  test::move(scene.objects[2], {0.0, 0.4, 0.0}, {0.0, 0.4, 0.0});
  if (moves) {
    scene.objects[0].transform.keys[1].translate = {-0.2, -0.2, 1.3};
    scene.objects[2].transform.keys[1].translate = {0.3, 0.2, -0.4};
    scene.objects[2].transform.keys[1].rotate_radians = 0.4;
  }
  return scene;
}

TEST(Defocus, StillPicturesOfAllMethodsAreOne) {
  Scene scene = still_life(false);
  open_lens(scene, 0.3, 5.0, 48);
  const Image image = sampled(scene, 1);
  EXPECT_EQ(image.rgba, exact(scene).rgba);
  EXPECT_EQ(image.depth, exact(scene).depth);
  const Image truth = reference(scene, 2);
  EXPECT_GE(decibels(image, truth), 90.0);
  for (std::size_t i = 0; i < truth.depth.size(); ++i) {
    if (!std::isfinite(truth.depth[i])) continue;
    EXPECT_NEAR(image.depth[i], truth.depth[i], 1e-3 * truth.depth[i]) << i;
  }
}

TEST(Defocus, FastAndOutOfFocusAtOnce) {
  Scene scene = still_life(true);
  open_lens(scene, 0.3, 5.0, 24);
  scene.model.segments = 4;
  // Keyed: the focus is pulled while the shutter is open.
  scene.camera.look_ats.push_back(scene.camera.look_ats.front());
  scene.camera.look_ats[1].frame = 1.0;
  scene.camera.look_ats[1].lens.focus = 4.5;
  EXPECT_GE(decibels(exact(scene), reference(scene, 64, ReferenceMotion::segments)), 60.0);
  // Each point of the lens at as many instants as the reference has. They begin at other times.
  EXPECT_GE(decibels(sampled(scene, 24 * 64), reference(scene, 64)), 60.0);
  // With one instant for each point the sum is no worse than with as many instants for one point.
  open_lens(scene, 0.3, 5.0, 512);
  scene.camera.look_ats[1].lens.focus = 4.5;
  EXPECT_GE(decibels(sampled(scene, 512), sampled(scene, 8192)), 45.0);
}

TEST(Defocus, TheEyeAndTheFilmMoveWithTheLens) {
  // Not square pixels, a principal point off the middle, a crop, and a camera that rolls: as always.
  Scene scene = still_life(false);
  open_lens(scene, 0.3, 4.0, 16, 6);
  LookAtKey& key = scene.camera.look_ats[0];
  key.lens.stretch_x = 1.5;
  key.lens.shift = {0.2, -0.1};
  key.roll_radians = 0.3;
  const Image whole = sampled(scene, 1);
  EXPECT_GE(decibels(whole, reference(scene, 2)), 90.0);
  scene.film.crop_x = 11, scene.film.crop_y = 7, scene.film.crop_width = 30, scene.film.crop_height = 20;
  const Image crop = sampled(scene, 1);
  EXPECT_TRUE(test::is_crop_of(crop, whole, scene.film));
}

TEST(Defocus, PointsAreChosenFromTheCircleOfConfusion) {
  Scene scene = speck();
  EXPECT_EQ(lens_point_count(scene), 1);
  open_lens(scene, 1.0, 4.0, 0);
  EXPECT_EQ(lens_point_count(scene), 227);  // 8 · π/4 · 6²
  open_lens(scene, 1.0, 8.0, 0);
  EXPECT_EQ(lens_point_count(scene), 64);
  open_lens(scene, 100.0, 4.0, 0);
  EXPECT_EQ(lens_point_count(scene), 1024);
  open_lens(scene, 1.0, 4.0, 7);
  EXPECT_EQ(lens_point_count(scene), 7);
}

TEST(Defocus, ALensOfRadiusZeroIsNone) {
  Scene scene = still_life(true);
  const Image pinhole = sampled(scene, 8), swept = exact(scene);
  open_lens(scene, 0.0, 5.0, 64, 6);
  EXPECT_EQ(sampled(scene, 8).rgba, pinhole.rgba);
  EXPECT_EQ(exact(scene).rgba, swept.rgba);
}

TEST(Defocus, WhatCannotBeIsRefused) {
  const auto field_of = [](const Result<Rendered>& rendered) {
    return rendered.ok() ? std::string("none") : rendered.error().field;
  };
  Scene scene = still_life(true);
  open_lens(scene, 0.3, 0.0, 0);
  EXPECT_EQ(field_of(render_sampled(scene)), "/camera/keys/0/focus");
  open_lens(scene, -1.0, 5.0, 0);
  EXPECT_EQ(field_of(render_sampled(scene)), "/camera/lens/aperture");
  open_lens(scene, 0.3, 5.0, 0, 2);
  EXPECT_EQ(field_of(render_sampled(scene)), "/camera/lens/blades");
  open_lens(scene, 0.3, 5.0, 5000);
  EXPECT_EQ(field_of(render_sampled(scene)), "/camera/lens/samples");
  open_lens(scene, 0.3, 5.0, 4);
  SampledOptions options;
  options.max_seconds = 1.0;
  EXPECT_EQ(field_of(render_sampled(scene, options)), "max_seconds");
  options = {};
  options.error_channel = true;
  EXPECT_EQ(field_of(render_sampled(scene, options)), "error_channel");
  scene.objects.resize(1);
  scene.objects[0].cloud = {};
  scene.objects[0].splats.position = {{0, 0, 0}};
  EXPECT_NE(field_of(render_sampled(scene)), "none");
}

}  // namespace
}  // namespace swept
