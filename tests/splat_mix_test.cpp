// Splats and discs in one picture: what is seen follows from each by itself, as the rule of blending has it.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/sampled.h"
#include "abuffer/simd/splat_math.h"
#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using test::psnr_db;
using test::random_splats;

double decoded(double s) {
  const double v = std::abs(s);
  return std::copysign(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4), s);
}
double encoded(double light) {
  const double v = std::abs(light);
  return std::copysign(v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055, light);
}

Rendered rendered(const Scene& scene, const SampledOptions& options = {}) {
  return test::value_of(render_sampled(scene, options));
}

/// A round disc that faces the camera, with a soft rim.
Object disc_at(double z, double radius, float opacity, const Eigen::Vector3f& color) {
  Object object;
  const auto r = static_cast<float>(radius);
  object.cloud.keys.push_back({0.0, {{{0, 0, z}}, {{r, 0, 0}}, {{0, r, 0}}}});
  object.cloud.opacity = {opacity};
  object.cloud.color = {color};
  return object;
}

/// The splats of a scene whose centres lie in [from, to), without its discs and over black.
Scene only_splats(const Scene& scene, double from, double to) {
  Scene part = scene;
  part.objects.clear();
  part.background.setZero();
  for (const Object& object : scene.objects) {
    if (object.splats.size() == 0) continue;
    part.objects.push_back(object);
    SplatCloud& cloud = part.objects.back().splats;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (!(cloud.position[i].z() >= from && cloud.position[i].z() < to)) cloud.opacity[i] = 0.0f;
  }
  return part;
}

Scene still(Scene scene) {
  scene.shutter = {0.0, 0.0};
  for (Object& object : scene.objects) object.splats.velocity.clear();
  return scene;
}

TEST(SplatMix, SurfacesAndRunsOfSplatsCoverEachOther) {
  for (const bool linear : {false, true}) {
    Scene scene = still(random_splats(900, 31));
    scene.background = {0.2f, 0.4f, 0.1f, 0.5f};
    scene.splats.least_light = 0.0;
    scene.model.depth_tolerance = 0.01;  // or both discs are one surface
    if (linear) scene.splats.blending = SplatBlending::linear;
    const double depths[2] = {6.0, 8.0};
    scene.objects.push_back(disc_at(depths[0], 2.0, 0.6f, {0.9f, 0.2f, 0.1f}));
    scene.objects.push_back(disc_at(depths[1], 4.0, 1.0f, {0.1f, 0.3f, 0.8f}));
    const Image image = rendered(scene).image;

    std::vector<Image> runs, surfaces;
    for (const auto& [from, to] : {std::pair{0.0, 6.0}, {6.0, 8.0}, {8.0, 99.0}})
      runs.push_back(rendered(only_splats(scene, from, to)).image);
    for (std::size_t k = 1; k <= 2; ++k) {
      Scene alone = scene;
      alone.background.setZero();
      alone.objects = {scene.objects[k]};
      surfaces.push_back(rendered(alone).image);
    }
    double worst = 0.0, worst_alpha = 0.0, worst_depth = 0.0;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      double through = 1.0, depth = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double run = double{runs[k].rgba[4 * i + 3]};
        if (run > 0.0) depth += through * run * double{runs[k].depth[i]};
        through *= 1.0 - run;
        if (k == 2) break;
        const double surface = double{surfaces[k].rgba[4 * i + 3]};
        depth += through * surface * depths[k];
        through *= 1.0 - surface;
      }
      for (std::size_t c = 0; c < 3; ++c) {
        double behind = double{scene.background[static_cast<int>(c)]};
        for (std::size_t k = 3; k-- > 0;) {
          const double left = 1.0 - double{runs[k].rgba[4 * i + 3]}, own = double{runs[k].rgba[4 * i + c]};
          behind = linear ? own + left * behind : decoded(encoded(own) + left * encoded(behind));
          if (k > 0)
            behind = double{surfaces[k - 1].rgba[4 * i + c]} +
                     (1.0 - double{surfaces[k - 1].rgba[4 * i + 3]}) * behind;
        }
        worst = std::max(worst, std::abs(behind - double{image.rgba[4 * i + c]}));
      }
      const double alpha = 1.0 - through;
      worst_alpha = std::max(worst_alpha, std::abs(alpha + 0.5 * through - double{image.rgba[4 * i + 3]}));
      if (alpha > 0.05) worst_depth = std::max(worst_depth, std::abs(depth / alpha - double{image.depth[i]}));
    }
    EXPECT_LE(worst, 2e-5) << linear;
    EXPECT_LE(worst_alpha, 2e-6) << linear;
    EXPECT_LE(worst_depth, 2e-4) << linear;
  }
}

TEST(SplatMix, ADiscBehindAllIsABackgroundAndOneBeforeAllHidesThem) {
  Scene scene = still(random_splats(500, 32));
  Scene behind = scene, over = scene;
  behind.objects.push_back(disc_at(50.0, 200.0, 1.0f, {0.5f, 0.25f, 0.125f}));
  over.background = {0.5f, 0.25f, 0.125f, 1.0f};
  EXPECT_GE(psnr_db(rendered(behind).image, rendered(over).image), 110.0);
  Scene hidden = scene, alone = scene;
  hidden.objects.push_back(disc_at(1.0, 20.0, 1.0f, {0.5f, 0.25f, 0.125f}));
  alone.objects = {hidden.objects.back()};
  EXPECT_GE(psnr_db(rendered(hidden).image, rendered(alone).image), 120.0);
}

TEST(SplatMix, SplatsThatDoNotShowLeaveDiscsAsTheyAre) {
  Scene scene = still(random_splats(1, 33));
  scene.background = {0.2f, 0.4f, 0.1f, 1.0f};
  for (const double z : {5.0, 6.0, 7.0})
    scene.objects.push_back(disc_at(z, 0.4 * z, 0.5f, {0.9f, 0.2f, 0.1f}));
  Scene alone = scene;
  alone.objects.erase(alone.objects.begin());
  scene.objects[0].splats.position[0] = {0, 0, -5};
  EXPECT_GE(psnr_db(rendered(scene).image, rendered(alone).image), 120.0);
}

TEST(SplatMix, BothMoveAndBitsDoNotDependOnInstructionsThreadsOrCrop) {
  Scene scene = random_splats(600, 34);
  for (const double z : {5.0, 7.0}) {
    Object disc = disc_at(z, 0.3 * z, 0.8f, {0.1f, 0.3f, 0.8f});
    disc.cloud.velocity = {{1.5f, 0.5f, 0.0f}};
    scene.objects.push_back(disc);
  }
  SampledOptions many;
  many.samples = 400;
  const Rendered result = rendered(scene);
  EXPECT_GE(psnr_db(result.image, rendered(scene, many).image), 60.0);
  EXPECT_GT(test::counter(result, "most_instants"), 2.0);
  for (int i = 0; i < static_cast<int>(splat_maths().count); ++i) {
    SampledOptions options;
    options.implementation = i;
    EXPECT_EQ(rendered(scene, options).image.rgba, result.image.rgba) << splat_maths().first[i].name;
  }
  RenderControl one;
  one.threads = 1;
  EXPECT_EQ(render_sampled(scene, {}, one)->image.rgba, result.image.rgba);
  Scene cropped = scene;
  cropped.film.crop_x = 70, cropped.film.crop_y = 40, cropped.film.crop_width = 20,
  cropped.film.crop_height = 30;
  const Image window = rendered(cropped).image;
  EXPECT_TRUE(test::is_crop_of(window, result.image, cropped.film));
}

TEST(SplatMix, DiscsThatMoveAmongStandingSplatsAreBlurred) {
  Scene scene = random_splats(300, 35);
  scene.objects[0].splats.velocity.clear();
  Object disc = disc_at(6.5, 1.0, 1.0f, {0.9f, 0.9f, 0.1f});
  disc.cloud.velocity = {{1.0f, 0.0f, 0.0f}};
  scene.objects.push_back(disc);
  SampledOptions many;
  many.samples = 400;
  const Rendered result = rendered(scene);
  EXPECT_EQ(test::counter(result, "splats_moving"), 0.0);
  EXPECT_GE(psnr_db(result.image, rendered(scene, many).image), 60.0);
}

}  // namespace
}  // namespace swept
