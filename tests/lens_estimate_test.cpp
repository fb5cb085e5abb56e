// How many looks through a lens an error takes, and the lens of triangles and of splats.
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/lens_looks.h"
#include "abuffer/sampled.h"
#include "abuffer/stochastic/stochastic.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using test::reference;

Rendered to_db(const Scene& scene, double db) {
  SampledOptions options;
  options.max_error_db = db;
  return test::value_of(render_sampled(scene, options));
}
void open_lens(Scene& scene, double diameter, double focus, int points = 0, int blades = 0) {
  scene.camera.aperture = {0.5 * diameter, blades, 0.0, points};
  for (LookAtKey& key : scene.camera.look_ats) key.lens.focus = focus;
}

TEST(LensLooks, HalvesFillLensAndTimeByThemselves) {
  Scene scene = test::stage();
  open_lens(scene, 2.0, 5.0);
  const LensLooks looks(scene, 0);
  ASSERT_TRUE(looks.any() && !looks.given());
  for (const int begin : {0, 64, 128}) {
    const int count = begin == 128 ? 128 : 64;
    double x = 0.0, y = 0.0, square = 0.0, time = 0.0;
    std::vector<int> strata(static_cast<std::size_t>(count));
    for (int i = begin; i < begin + count; ++i) {
      const LensLook look = looks.at(i, 1);
      EXPECT_LE(look.point.norm(), 1.0);
      x += look.point.x() / count, y += look.point.y() / count;
      square += look.point.squaredNorm() / count;
      time += look.share / count;
      ++strata[static_cast<std::size_t>(look.share * count)];
    }
    // At random 0.06, 0.06, 0.04 and 0.04 would be due.
    EXPECT_NEAR(x, 0.0, 0.03) << begin;
    EXPECT_NEAR(y, 0.0, 0.03) << begin;
    EXPECT_NEAR(square, 0.5, 0.01) << begin;
    EXPECT_NEAR(time, 0.5, 0.005) << begin;
    for (const int in_stratum : strata) EXPECT_EQ(in_stratum, 1) << begin;
  }
}

/// Balls at random depths, some of which move, one of them transparent; lens and focus at random.
Scene any_scene(unsigned seed) {
  test::Random random(seed);
  Scene scene = test::stage();
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  for (int n = 0; n < 5; ++n) {
    Object object = test::checkered_sphere(random(0.2, 0.8), 150 + 60 * n);
    const Eigen::Vector3d at(random(-1.6, 1.6), random(-1.2, 1.2), random(-4.0, 2.5));
    const double px = std::pow(2.0, random(-2.0, 5.0));
    const double way = px * (5.0 - at.z()) / 48.0;
    const Eigen::Vector3d to = at + way * random.vector(-1.0, 1.0).normalized();
    test::move(object, at, n % 2 == 0 ? at : to, n == 3 ? random(0.0, 1.0) : 0.0);
    if (n == 4) object.cloud.opacity.assign(object.cloud.size(), 0.5f);
    scene.objects.push_back(std::move(object));
  }
  open_lens(scene, random(0.05, 0.6), random(2.5, 8.0), 0, seed % 3 == 0 ? 6 : 0);
  if (seed % 4 == 0) {
    scene.camera.look_ats.push_back(scene.camera.look_ats.front());
    scene.camera.look_ats[1].frame = 1.0;
    scene.camera.look_ats[1].lens.focus *= 1.3;
  }
  return scene;
}

/// Through 4096 points of another spread, each at so many instants.
Image truth_of(const Scene& scene, int instants) {
  Scene many = scene;
  many.camera.aperture.samples = 4096;
  return test::sampled(many, 4096 * instants);
}

TEST(LensEstimate, MeetsWhatIsAskedForOnScenesItWasNotMadeFor) {
  struct Asked {
    double db;
    unsigned scenes;  ///< few where the truth takes long
    int instants;     ///< of the truth
    unsigned met = 0;
    double logs = 0.0, worst = 0.0, looks = 0.0;
  };
  for (Asked asked : {Asked{45.0, 10, 1}, {60.0, 10, 1}, {75.0, 3, 4}}) {
    for (unsigned seed = 1; seed <= asked.scenes; ++seed) {
      const Scene scene = any_scene(seed);
      const Image truth = truth_of(scene, asked.instants);
      const Rendered image = to_db(scene, asked.db);
      const double reached = test::psnr_db(image.image, truth);
      const double expected = image.statistics.counter("expected_psnr_db").value_or(0.0);
      const double ratio = std::pow(10.0, (expected - reached) / 20.0);
      asked.met += reached >= asked.db ? 1 : 0;
      asked.worst = std::max(asked.worst, ratio);
      asked.logs += std::log(ratio) / asked.scenes;
      asked.looks += image.statistics.counter("instants_per_pixel").value_or(0.0) / asked.scenes;
      EXPECT_GE(reached, asked.db - 2.0) << seed;
    }
    std::printf("%.0f dB met by %u of %u; true to estimated error %.2f, at worst %.2f; %.0f looks a pixel\n",
                asked.db, asked.met, asked.scenes, std::exp(asked.logs), asked.worst, asked.looks);
    EXPECT_GE(5 * asked.met, 4 * (asked.scenes - 1)) << asked.db;
    EXPECT_LE(asked.worst, 2.0) << asked.db;
    EXPECT_GE(std::exp(asked.logs), 0.4) << asked.db << ": it would take far too many";
  }
}

TEST(LensEstimate, WhatIsNotBlurredTakesFewLooks) {
  Scene scene = test::stage();
  Object object;
  test::add_disc(object, {0, 0, 0}, {0, 0, 1}, 1.0);
  scene.objects = {object};
  open_lens(scene, 0.4, 5.0);
  const Rendered sharp = to_db(scene, 60.0);
  EXPECT_LE(sharp.statistics.counter("most_instants").value_or(0.0), 16.0);
  open_lens(scene, 0.4, 2.0);
  const Rendered blurred = to_db(scene, 60.0);
  EXPECT_GE(blurred.statistics.counter("most_instants").value_or(0.0), 64.0);
  EXPECT_LE(to_db(scene, 40.0).statistics.counter("instants_per_pixel").value_or(0.0),
            0.5 * blurred.statistics.counter("instants_per_pixel").value_or(0.0));
  // With an estimate there is a channel of it, and time can be spent by it.
  SampledOptions options;
  options.error_channel = true;
  const Rendered estimated = test::value_of(render_sampled(scene, options));
  ASSERT_EQ(estimated.image.channels.size(), 1u);
  double most = 0.0;
  for (const float error : estimated.image.channels[0].values) most = std::max(most, double{error});
  EXPECT_GT(most, 0.0);
  options = {};
  options.max_seconds = 0.2;
  EXPECT_GE(test::psnr_db(test::value_of(render_sampled(scene, options)).image, blurred.image), 30.0);
}

TEST(LensEstimate, CropsAndThreadsChangeNoBit) {
  Scene scene = any_scene(4);
  scene.film = {160, 120, 0, 0, 0, 0};
  const Image whole = to_db(scene, 50.0).image;
  RenderControl control;
  control.threads = 1;
  SampledOptions options;
  options.max_error_db = 50.0;
  EXPECT_EQ(render_sampled(scene, options, control)->image.rgba, whole.rgba);
  scene.film.crop_x = 50, scene.film.crop_y = 40, scene.film.crop_width = 33, scene.film.crop_height = 37;
  const Image crop = to_db(scene, 50.0).image;
  EXPECT_TRUE(test::is_crop_of(crop, whole, scene.film));
}

/// Triangles near and far, opaque and not, two meshes of them, which turn.
Scene of_triangles(bool moves) {
  Scene scene = test::stage();
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  test::Random random(9);
  for (int n = 0; n < 2; ++n) {
    Object object = test::triangles_about(15, n == 0 ? 1.0f : 0.6f, random, [&] {
      const double x = random(-1.5, 1.5), y = random(-1.2, 1.2);
      return Eigen::Vector3d(x, y, random(-3.0, 2.0));
    });
    test::move(object, {0, 0, 0}, moves ? Eigen::Vector3d(-0.3, 0.2 * n, 0.3) : Eigen::Vector3d(0, 0, 0),
               moves ? 0.5 : 0.0);
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

TEST(LensOfTriangles, IsThatOfTheReference) {
  Scene scene = of_triangles(false);
  open_lens(scene, 0.3, 5.0, 24, 5);
  EXPECT_GE(test::psnr_db(test::sampled(scene, 1), reference(scene, 2)), 70.0);
  scene = of_triangles(true);
  open_lens(scene, 0.3, 5.0, 8);
  // Keyed: the focus is pulled while the shutter is open.
  scene.camera.look_ats.push_back(scene.camera.look_ats.front());
  scene.camera.look_ats[1].frame = 1.0;
  scene.camera.look_ats[1].lens.focus = 4.0;
  EXPECT_GE(test::psnr_db(test::sampled(scene, 8 * 128), reference(scene, 128)), 70.0);
  // Every point exactly.
  const Result<Rendered> swept = render_abuffer(scene);
  ASSERT_TRUE(swept.ok()) << swept.error().message();
  EXPECT_GE(test::psnr_db(swept->image, reference(scene, 128)), 60.0);
  // As many points as the error takes, against random samples of lens and time.
  open_lens(scene, 0.3, 5.0);
  const Rendered image = to_db(scene, 60.0);
  scene.camera.aperture.samples = 1024;
  EXPECT_GE(test::psnr_db(image.image, test::sampled(scene, 2048)), 58.0);
  EXPECT_GE(image.statistics.counter("expected_psnr_db").value_or(0.0), 60.0);
  // A mesh by itself.
  scene.objects.resize(1);
  StochasticOptions options;
  options.samples = 2048;
  const auto random = render_stochastic(scene, options);
  ASSERT_TRUE(random.ok());
  EXPECT_GE(test::psnr_db(test::sampled(scene, 2048), random->image), 38.0);
}

TEST(LensOfTriangles, AmongDiscs) {
  Scene scene = of_triangles(true);
  Object ball = test::checkered_sphere(0.6, 200);
  test::move(ball, {0.3, 0, -1}, {-0.3, 0.1, -0.5});
  scene.objects.push_back(std::move(ball));
  open_lens(scene, 0.3, 5.0, 8);
  EXPECT_GE(test::psnr_db(test::sampled(scene, 8 * 64), reference(scene, 64)), 60.0);
}

TEST(LensOfSplats, IsThatOfTheReference) {
  for (const bool flat : {false, true}) {
    Scene scene = test::random_splats(150, 5);
    scene.film = {75, 50, 0, 0, 0, 0};
    SplatCloud& cloud = scene.objects.front().splats;
    cloud.flat = flat;
    if (flat)
      for (Eigen::Vector3f& scale : cloud.scale) scale.z() = 0.0f;
    scene.shutter = {0.5, 0.5};
    open_lens(scene, 0.4, 6.0, 16, 6);
    EXPECT_GE(test::psnr_db(test::sampled(scene, 1), reference(scene, 2)), 90.0) << flat;
    scene.shutter = {0.0, 1.0};
    EXPECT_GE(test::psnr_db(test::sampled(scene, 16 * 16), reference(scene, 16)), 70.0) << flat;
    open_lens(scene, 0.4, 6.0);
    const Rendered image = to_db(scene, 60.0);
    scene.camera.aperture.samples = 2048;
    EXPECT_GE(test::psnr_db(image.image, test::sampled(scene, 4096)), 60.0) << flat;
  }
}

TEST(LensOfSplats, ARadiusOfZeroKeepsEveryBit) {
  Scene scene = test::random_splats(200, 6);
  const Image pinhole = to_db(scene, 60.0).image;
  open_lens(scene, 0.0, 6.0, 64, 6);
  EXPECT_EQ(to_db(scene, 60.0).image.rgba, pinhole.rgba);
  Scene mesh = of_triangles(true);
  const Image sharp = to_db(mesh, 50.0).image;
  open_lens(mesh, 0.0, 6.0, 64, 6);
  EXPECT_EQ(to_db(mesh, 50.0).image.rgba, sharp.rgba);
}

TEST(LensOfSplats, ASplatInFocusStaysSharp) {
  Scene scene = test::one_splat({0.1, 0.2, 4.0}, 0.1f, 0.9f, 0.7f);
  const Image sharp = test::sampled(scene, 1);
  open_lens(scene, 1.0, 4.0, 64);
  EXPECT_GE(test::psnr_db(test::sampled(scene, 1), sharp), 60.0);
  // Spread over 8 px. Of a Gaussian of variance s² and a disc of radius R, whose variance is R²/4 along each
  // axis, the peak falls to s²/(s² + R²/4) but for the disc not being a Gaussian: 1.6² + 0.3 px² to 4 px²
  // more.
  open_lens(scene, 1.0, 8.0, 64);
  const auto peak = [](const Image& image) {
    float most = 0.0f;
    for (std::size_t p = 0; p < image.pixel_count(); ++p) most = std::max(most, image.rgba[4 * p + 3]);
    return double{most};
  };
  EXPECT_NEAR(peak(test::sampled(scene, 1)) / peak(sharp), 2.86 / 6.86, 0.1);
}

}  // namespace
}  // namespace swept
