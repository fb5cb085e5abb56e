// The sampled engine on Gaussian splats: as the reference has them, and the same bits whatever does not
// matter.
#include "abuffer/sampled.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/simd/splat_math.h"
#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using test::psnr_db;
using test::random_splats;

Rendered rendered(const Scene& scene, const SampledOptions& options = {}, const RenderControl& control = {}) {
  return test::value_of(render_sampled(scene, options, control));
}

SampledOptions samples(int count) {
  SampledOptions options;
  options.samples = count;
  return options;
}

double worst_alpha(const Image& a, const Image& b) {
  double worst = 0.0;
  for (std::size_t i = 3; i < a.rgba.size(); i += 4)
    worst = std::max(worst, std::abs(double{a.rgba[i]} - double{b.rgba[i]}));
  return worst;
}

/// √ of the mean square of relative depths, weighted by alpha.
double depth_error(const Image& a, const Image& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.depth.size(); ++i) {
    const double alpha = double{b.rgba[4 * i + 3]};
    if (alpha > 0.01) squares += std::pow(alpha * (double{a.depth[i]} / double{b.depth[i]} - 1.0), 2);
  }
  return std::sqrt(squares / static_cast<double>(a.depth.size()));
}

/// The same instants, one by one.
void expect_as_the_reference(const Scene& scene, const char* what) {
  const Image ours = rendered(scene, samples(3)).image, theirs = test::splat_reference(scene, 3);
  EXPECT_GE(psnr_db(ours, theirs), 80.0) << what;
  // A splat left out on one side alone is 1/255.
  EXPECT_LE(worst_alpha(ours, theirs), 1.5 / 255.0) << what;
  EXPECT_LE(depth_error(ours, theirs), 1e-3) << what;
}

TEST(SplatEngine, DrawsWhatTheReferenceDraws) {
  const Scene base = random_splats(1500, 1);
  expect_as_the_reference(base, "motion of their own");
  Scene scene = base;
  scene.background = {0.3f, 0.1f, 0.6f, 0.5f};
  expect_as_the_reference(scene, "background");
  scene.splats.blending = SplatBlending::linear;
  expect_as_the_reference(scene, "linear light");
  scene = base;
  scene.objects[0].splats.filter = SplatFilter::antialiased;
  expect_as_the_reference(scene, "antialiased");
  scene = base;
  scene.splats.dilation_px2 = 0.0;
  scene.splats.most_alpha = 1.0;
  scene.splats.least_alpha = 1e-3;
  scene.splats.least_light = 0.0;
  scene.splats.near = 5.0;
  expect_as_the_reference(scene, "other constants");
  for (const int degree : {0, 1, 2}) {
    scene = base;
    SplatCloud& cloud = scene.objects[0].splats;
    cloud.degree = degree;
    cloud.harmonics.resize(cloud.size() * static_cast<std::size_t>(3 * SplatCloud::coefficients(degree)));
    expect_as_the_reference(scene, "degree");
  }
}

TEST(SplatEngine, DrawsDiscsAsTheReferenceDoes) {
  for (const float size : {0.02f, 0.3f}) {
    Scene scene = random_splats(400, 2, size);
    SplatCloud& cloud = scene.objects[0].splats;
    cloud.flat = true;
    for (Eigen::Vector3f& scale : cloud.scale) scale.z() = 0.0f;
    expect_as_the_reference(scene, "discs");
    // And both kinds in one picture.
    scene.objects.push_back(random_splats(400, 3).objects[0]);
    expect_as_the_reference(scene, "discs and ellipsoids");
  }
}

TEST(SplatEngine, FollowsCameraAndObject) {
  Scene scene = random_splats(800, 4);
  scene.objects[0].splats.velocity.clear();
  LookAtKey key = test::looking_along_z(1.0, {0.5, 0.2, 0.5}, {0.2, 0, 3}, 35.0);
  key.roll_radians = 0.3;
  key.lens.stretch_x = 1.3;
  key.lens.shift = {0.2, -0.1};
  scene.camera.look_ats.push_back(key);
  expect_as_the_reference(scene, "camera, lens and zoom");
  TransformKey from, to;
  from.translate = {0, 0, 1};
  from.scale = {1, 1, 1};
  to.frame = 1.0;
  to.translate = {1, 0, 2};
  to.rotate_axis = {0, 0, 1};
  to.rotate_radians = 1.0;
  to.scale = {0.8, -1.2, 1.0};
  scene.objects[0].transform.keys = {from, to};
  expect_as_the_reference(scene, "object");
  // Through the splats, past the near plane.
  scene.camera.look_ats.back().eye = {0, 0, 8};
  scene.camera.look_ats.back().target = {0, 0, 20};
  expect_as_the_reference(scene, "into the splats");
}

TEST(SplatEngine, FarFromTheOriginNothingIsLost) {
  Scene scene = random_splats(500, 5);
  const Image near = rendered(scene, samples(2)).image;
  const Eigen::Vector3d away(4e6, -5e6, 3e5);
  for (Eigen::Vector3d& position : scene.objects[0].splats.position) position += away;
  for (LookAtKey& key : scene.camera.look_ats) key.eye += away, key.target += away;
  // Positions are doubles; 5·10⁶ leaves 10⁻⁹ of them.
  EXPECT_GE(psnr_db(rendered(scene, samples(2)).image, near), 90.0);
}

TEST(SplatEngine, BitsDoNotDependOnInstructionsThreadsCropOrOrder) {
  Scene scene = random_splats(1200, 6);
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  Scene discs = random_splats(300, 7);
  discs.objects[0].splats.flat = true;
  scene.objects.push_back(discs.objects[0]);
  const Image image = rendered(scene).image;
  const auto same = [&](const Image& other) {
    return other.rgba == image.rgba && other.depth == image.depth;
  };
  for (int i = 0; i < static_cast<int>(splat_maths().count); ++i) {
    SampledOptions options;
    options.implementation = i;
    EXPECT_TRUE(same(rendered(scene, options).image)) << splat_maths().first[i].name;
  }
  RenderControl one;
  one.threads = 1;
  EXPECT_TRUE(same(rendered(scene, {}, one).image));

  Scene cropped = scene;
  cropped.film.crop_x = 50, cropped.film.crop_y = 30, cropped.film.crop_width = 45,
  cropped.film.crop_height = 60;
  const Image window = rendered(cropped).image;
  EXPECT_TRUE(test::is_crop_of(window, image, cropped.film));

  std::swap(scene.objects[0], scene.objects[1]);
  for (Object& object : scene.objects) {
    SplatCloud& c = object.splats;
    std::vector<std::size_t> order(c.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937(8));
    SplatCloud shuffled = c;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const std::size_t from = order[i];
      shuffled.position[i] = c.position[from], shuffled.scale[i] = c.scale[from];
      shuffled.rotation[i] = c.rotation[from], shuffled.opacity[i] = c.opacity[from];
      shuffled.velocity[i] = c.velocity[from];
      std::copy_n(c.harmonics.begin() + static_cast<std::ptrdiff_t>(48 * from), 48,
                  shuffled.harmonics.begin() + static_cast<std::ptrdiff_t>(48 * i));
    }
    c = shuffled;
  }
  EXPECT_TRUE(same(rendered(scene).image)) << "another order";
}

TEST(SplatEngine, SplatsAtOneDepthAreDrawnInAnOrderOfTheirOwn) {
  Scene scene = random_splats(200, 9);
  SplatCloud& cloud = scene.objects[0].splats;
  cloud.velocity.clear();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.position[i] = {0.25 * static_cast<double>(i % 10) - 1.0, 0.25 * static_cast<double>(i / 10 % 4),
                         7.0};
    cloud.opacity[i] = 0.9f;
  }
  const Image image = rendered(scene).image;
  std::reverse(cloud.position.begin(), cloud.position.end());
  std::reverse(cloud.scale.begin(), cloud.scale.end());
  std::reverse(cloud.rotation.begin(), cloud.rotation.end());
  std::vector<float> harmonics;
  for (std::size_t i = cloud.size(); i-- > 0;)
    harmonics.insert(harmonics.end(), cloud.harmonics.begin() + static_cast<std::ptrdiff_t>(48 * i),
                     cloud.harmonics.begin() + static_cast<std::ptrdiff_t>(48 * i + 48));
  cloud.harmonics = harmonics;
  EXPECT_EQ(rendered(scene).image.rgba, image.rgba);
}

TEST(SplatEngine, WhatStandsStillTakesOneInstant) {
  Scene scene = random_splats(600, 10);
  scene.film = {256, 192, 0, 0, 0, 0};
  SplatCloud& cloud = scene.objects[0].splats;
  const Scene moving = scene;
  cloud.velocity.assign(cloud.size(), Eigen::Vector3f::Zero());
  const Rendered still = rendered(scene);
  EXPECT_EQ(test::counter(still, "instants_per_pixel"), 1.0);
  EXPECT_EQ(test::counter(still, "splats_moving"), 0.0);
  Scene closed = scene;
  closed.shutter = {0.5, 0.5};
  EXPECT_EQ(rendered(closed).image.rgba, still.image.rgba);

  // One that moves touches a few of the twelve cells; the others keep their bits.
  std::size_t one = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if ((cloud.position[i] / cloud.position[i].z()).head<2>().norm() <
        (cloud.position[one] / cloud.position[one].z()).head<2>().norm())
      one = i;
  cloud.velocity[one] = {0.2f, 0.0f, 0.0f};
  cloud.opacity[one] = 1.0f;
  Scene frozen = scene;
  frozen.objects[0].splats.velocity[one].setZero();
  const Rendered local = rendered(scene), none = rendered(frozen);
  EXPECT_EQ(test::counter(local, "splats_moving"), 1.0);
  EXPECT_GT(test::counter(local, "instants_per_pixel"), 1.0);
  EXPECT_LT(test::counter(local, "instants_per_pixel"), 3.0);
  EXPECT_GT(test::counter(local, "most_instants"), 1.0);
  EXPECT_NE(local.image.rgba, none.image.rgba);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(local.image.rgba[i], none.image.rgba[i]);
  EXPECT_GE(psnr_db(local.image, test::splat_reference(scene, 64)), 60.0);
}

TEST(SplatEngine, OnlyStandingLeavesOutWhatMoves) {
  Scene scene = random_splats(400, 11);
  SplatCloud& cloud = scene.objects[0].splats;
  for (std::size_t i = 0; i < cloud.size(); i += 2) cloud.velocity[i].setZero();
  SampledOptions options;
  options.only_standing = true;
  const Image standing = rendered(scene, options).image;
  for (std::size_t i = 1; i < cloud.size(); i += 2) cloud.opacity[i] = 0.0f;
  EXPECT_EQ(rendered(scene).image.rgba, standing.rgba);
}

TEST(SplatEngine, MeetsTheErrorAskedFor) {
  for (const unsigned seed : {21u, 22u, 23u, 24u}) {
    Scene scene = random_splats(700, seed, 0.05f * static_cast<float>(seed - 20));
    const Image truth = rendered(scene, samples(512)).image;
    for (const double wanted : {45.0, 60.0, 70.0}) {
      SampledOptions options;
      options.max_error_db = wanted;
      const Rendered result = rendered(scene, options);
      EXPECT_GE(psnr_db(result.image, truth), wanted) << seed;
      EXPECT_GE(test::counter(result, "expected_psnr_db"), wanted) << seed;
      EXPECT_LE(test::counter(result, "instants_per_pixel"), 200.0) << seed;
    }
    EXPECT_GT(test::counter(rendered(scene), "fastest_splat_px"), 1.0);
  }
}

TEST(SplatEngine, TellsTheErrorOfEveryPixelAndTheInstantsOfEveryCell) {
  Scene scene = random_splats(700, 25, 0.2f);
  const Image truth = rendered(scene, samples(512)).image;
  SampledOptions options = samples(6);
  options.error_channel = true;
  const Rendered result = rendered(scene, options);
  ASSERT_EQ(result.image.channels.size(), 1u);
  EXPECT_EQ(result.image.channels[0].name, "error");
  double expected = 0.0, actual = 0.0;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    expected += 3.0 * std::pow(double{result.image.channels[0].values[i]}, 2);
    for (std::size_t c = 0; c < 3; ++c)
      actual += std::pow(double{result.image.rgba[4 * i + c]} - double{truth.rgba[4 * i + c]}, 2);
  }
  // Of the squares: an estimate, within 6 dB.
  EXPECT_GT(expected, 0.25 * actual);
  EXPECT_LT(expected, 4.0 * actual);
  EXPECT_EQ(rendered(scene, samples(6)).image.rgba, result.image.rgba);
  double px = 0.0;
  for (const FilmPart& part : result.parts) px += double{1.0} * part.width * part.height;
  EXPECT_EQ(px, 150.0 * 100.0);
}

TEST(SplatEngine, SpendsTheSecondsItIsGiven) {
  Scene scene = random_splats(1500, 26, 0.2f);
  const Image truth = rendered(scene, samples(512)).image;
  SampledOptions little, much;
  little.max_seconds = 1e-3;
  much.max_seconds = 2.0;
  const Rendered coarse = rendered(scene, little), fine = rendered(scene, much);
  EXPECT_GT(test::counter(fine, "instants_per_pixel"), test::counter(coarse, "instants_per_pixel"));
  EXPECT_GT(psnr_db(fine.image, truth), psnr_db(coarse.image, truth));
  EXPECT_GE(psnr_db(coarse.image, truth), 25.0);
}

TEST(SplatEngine, AskedForTheImpossibleItSaysSo) {
  Scene scene = random_splats(50, 12);
  EXPECT_FALSE(render_abuffer(scene).ok());
  RenderControl little;
  little.max_bytes = 1000;
  EXPECT_FALSE(render_sampled(scene, {}, little).ok());
  std::stop_source stop;
  stop.request_stop();
  RenderControl control;
  control.stop = stop.get_token();
  EXPECT_FALSE(render_sampled(scene, {}, control).ok());
  Scene both = scene;
  both.objects.push_back(scene.objects[0]);
  both.objects[1].splats.colors = SplatColors::linear;
  EXPECT_FALSE(render_sampled(both).ok());
  scene.objects[0].splats.opacity[7] = 2.0f;
  EXPECT_FALSE(render_sampled(scene).ok());
}

TEST(SplatEngine, TellsItsProgress) {
  const Scene scene = random_splats(300, 13);
  double last = 0.0;
  int calls = 0;
  RenderControl control;
  control.progress = [&](double share) {
    EXPECT_GE(share, last);
    EXPECT_LE(share, 1.0);
    last = share;
    ++calls;
  };
  rendered(scene, {}, control);
  EXPECT_GT(calls, 3);
  EXPECT_EQ(last, 1.0);
}

TEST(SplatEngine, DrawsTheTrainedHeadFromManySides) {
  SWEPT_DATA_OR_SKIP(data);
  Scene scene = test::try_scene(data);
  const Eigen::Vector3d middle(-60, 0, 450);
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(-60, 0, 100), Eigen::Vector3d(250, -50, 300),
                                     Eigen::Vector3d(-60, 200, 600), Eigen::Vector3d(-60, 0, 380)}) {
    scene.camera.look_ats = {test::looking_along_z(0.0, eye, middle, 60.0)};
    EXPECT_GE(psnr_db(rendered(scene).image, test::splat_reference(scene, 1)), 80.0) << eye.transpose();
  }
}

TEST(SplatEngine, BlursTheTrainedHeadToTheDefaultError) {
  SWEPT_DATA_OR_SKIP(data);
  Scene scene = test::try_moving_scene(data);
  const LookAtKey from = scene.camera.look_ats[0];
  for (const Eigen::Vector3d& way :
       {Eigen::Vector3d(15, 0, 0), Eigen::Vector3d(150, 0, 0), Eigen::Vector3d(0, 20, 120)}) {
    LookAtKey to = from;
    to.frame = 1.0;
    to.eye += way;
    if (way.z() == 0.0) to.target += way;
    scene.camera.look_ats = {from, to};
    const Rendered result = rendered(scene);
    EXPECT_GE(psnr_db(result.image, rendered(scene, samples(256)).image), 60.0) << way.transpose();
    EXPECT_LE(test::counter(result, "instants_per_pixel"), 32.0) << way.transpose();
  }
}

}  // namespace
}  // namespace swept
