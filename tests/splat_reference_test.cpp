// The reference of Gaussian splats against an independent program's pictures, and against what can be worked
// out by hand.
#include "abuffer/reference/splat_reference.h"

#include <cmath>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "splat/io/image_file.h"
#include "splat/io/splat_file.h"
#include "tests/drawn.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using test::one_splat;
using test::psnr_db;

double decoded(double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); }

Image drawn(const Scene& scene, int samples = 1) { return test::splat_reference(scene, samples); }

TEST(SplatReference, MatchesAnIndependentStill) {
  SWEPT_DATA_OR_SKIP(data);
  const Scene scene = test::try_scene(data);
  const Result<Image> theirs = read_exr(data + "gaussians/try_still.exr");
  ASSERT_TRUE(theirs.ok()) << theirs.error().message();
  const double db = psnr_db(drawn(scene), *theirs);
  RecordProperty("psnr_db", std::to_string(db));
  EXPECT_GE(db, 75.0);
}

TEST(SplatReference, MatchesAnIndependentMovingPicture) {
  SWEPT_DATA_OR_SKIP(data);
  const Scene scene = test::try_moving_scene(data);
  const Result<Image> theirs = read_exr(data + "gaussians/try_move.exr");
  ASSERT_TRUE(theirs.ok()) << theirs.error().message();
  // Sixteen stills are off by 73 dB from many.
  const double db = psnr_db(drawn(scene, 24), *theirs);
  RecordProperty("psnr_db", std::to_string(db));
  EXPECT_GE(db, 60.0);
}

/// The pixel whose centre is half a pixel right of and below the film's middle.
constexpr std::size_t middle = 24 * 64 + 32;

TEST(SplatReference, BlendsOneSplatAsTheFormulasSay) {
  Scene scene = one_splat({0, 0, 8}, 0.5f, 0.75f, 0.6f);
  scene.background = {0.25f, 0.25f, 0.25f, 0.5f};
  const Image image = drawn(scene);
  // Focal length 64 px: 0.5 at 8 away is 4 px, and the film adds 0.3 px².
  const double alpha = 0.75 * std::exp(-0.5 * 0.5 / (16.0 + 0.3)), behind = 0.5370987304831942;  // sRGB of ¼
  EXPECT_NEAR(image.rgba[4 * middle], decoded(0.6 * alpha + behind * (1.0 - alpha)), 1e-6);
  EXPECT_NEAR(image.rgba[4 * middle + 3], alpha + 0.5 * (1.0 - alpha), 1e-6);
  EXPECT_FLOAT_EQ(image.depth[middle], 8.0f);
  // α falls to 1/255 at r² = 2 ln(0.75 · 255), 13.08 px from the middle.
  EXPECT_GT(image.rgba[4 * (24 * 64 + 44) + 3], 0.5f);
  EXPECT_EQ(image.rgba[4 * (24 * 64 + 45) + 3], 0.5f);
}

TEST(SplatReference, BlendsInLinearLightWhereTheFileSaysSo) {
  Scene scene = one_splat({0, 0, 8}, 0.5f, 0.75f, 0.6f);
  scene.background = {0.25f, 0.25f, 0.25f, 0.5f};
  scene.splats.blending = SplatBlending::linear;
  const double alpha = 0.75 * std::exp(-0.5 * 0.5 / (16.0 + 0.3));
  EXPECT_NEAR(drawn(scene).rgba[4 * middle], 0.6 * alpha + 0.25 * (1.0 - alpha), 1e-6);
  scene.splats.blending = SplatBlending::file;
  scene.objects[0].splats.colors = SplatColors::linear;
  EXPECT_NEAR(drawn(scene).rgba[4 * middle], 0.6 * alpha + 0.25 * (1.0 - alpha), 1e-6);
}

TEST(SplatReference, AntialiasedSplatsKeepTheirLight) {
  Scene scene = one_splat({0, 0, 8}, 0.05f, 0.75f, 1.0f);
  const auto sum_of_alpha = [&] {
    const Image image = drawn(scene);
    double sum = 0.0;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) sum += double{image.rgba[4 * i + 3]};
    return sum;
  };
  scene.splats.least_alpha = 1e-6;
  // 0.4 px wide: 0.16 px² before, 0.46 px² after.
  const double before = sum_of_alpha();
  scene.objects[0].splats.filter = SplatFilter::antialiased;
  EXPECT_NEAR(sum_of_alpha() / before, 0.16 / 0.46, 1e-4);
}

TEST(SplatReference, NearAndOpaqueSplatsEndWhereTheModelSays) {
  Scene scene = one_splat({0, 0, 8}, 0.5f, 1.0f, 1.0f);
  SplatCloud& cloud = scene.objects[0].splats;
  cloud.opacity[0] = 1.0f;
  EXPECT_NEAR(drawn(scene).rgba[4 * middle + 3], 1.0 * std::exp(-0.25 / 16.3), 1e-6);
  scene.splats.near = 8.0;
  EXPECT_EQ(drawn(scene).rgba[4 * middle + 3], 0.0f);
  scene.splats.near = 0.2;
  // Three that would let 10⁻⁶ through: the third is not drawn.
  cloud.position = {{0, 0, 8}, {0, 0, 9}, {0, 0, 10}};
  cloud.scale.assign(3, Eigen::Vector3f::Constant(50.0f));
  cloud.rotation.assign(3, Eigen::Quaternionf::Identity());
  cloud.opacity.assign(3, 1.0f);
  cloud.harmonics.assign(9, 0.0f);
  EXPECT_NEAR(drawn(scene).rgba[4 * middle + 3], 1.0 - 1e-4, 1e-6);
  scene.splats.least_light = 0.0;
  EXPECT_NEAR(drawn(scene).rgba[4 * middle + 3], 1.0 - 1e-6, 1e-7);
}

TEST(SplatReference, DiscsAreMetByRays) {
  Scene scene = one_splat({0, 0, 8}, 0.5f, 0.75f, 1.0f);
  SplatCloud& cloud = scene.objects[0].splats;
  cloud.flat = true;
  cloud.scale[0] = {0.5f, 0.5f, 0.0f};
  // Turned about y by 60°: rays left of the middle meet it farther away.
  cloud.rotation[0] = Eigen::Quaternionf(Eigen::AngleAxisf(float(M_PI) / 3, Eigen::Vector3f::UnitY()));
  const Image image = drawn(scene);
  for (const int x : {28, 30, 34, 36}) {
    const double tangent = (x + 0.5 - 32.0) / 64.0, across = 0.5 / 64.0;
    // The plane z = 8 − x tan 60°.
    const double z = 8.0 / (1.0 + tangent * std::sqrt(3.0)), u = tangent * z / std::cos(M_PI / 3) / 0.5,
                 v = across * z / 0.5;
    EXPECT_NEAR(image.rgba[4 * (24 * 64 + static_cast<std::size_t>(x)) + 3],
                0.75 * std::exp(-0.5 * (u * u + v * v)), 1e-6)
        << x;
  }
  // Edge-on the low-pass is left: √½ px.
  cloud.rotation[0] = Eigen::Quaternionf(Eigen::AngleAxisf(float(M_PI) / 2, Eigen::Vector3f::UnitY()));
  EXPECT_NEAR(drawn(scene).rgba[4 * middle + 3], 0.75 * std::exp(-0.5), 1e-6);
}

TEST(SplatReference, ColoursAreSeenFromTheEyeAndTurnWithTheObject) {
  // Brighter the farther along +x one looks: coefficient −x of degree 1.
  Scene scene = one_splat({2, 0, 8}, 0.5f, 0.75f, 0.5f);
  SplatCloud& cloud = scene.objects[0].splats;
  cloud.degree = 1;
  cloud.harmonics.assign(12, 0.0f);
  for (int c = 0; c < 3; ++c) cloud.harmonics[static_cast<std::size_t>(9 + c)] = -0.4f;
  const auto color_at = [&](int x) {
    const Image image = drawn(scene);
    const float* rgba = &image.rgba[4 * (24 * 64 + static_cast<std::size_t>(x))];
    const double s = std::pow(double{rgba[0]}, 1 / 2.4) * 1.055 - 0.055;
    return s / double{rgba[3]};
  };
  const double c1 = std::sqrt(3.0 / (4.0 * M_PI));
  EXPECT_NEAR(color_at(48), 0.5 + 0.4 * c1 * 2.0 / std::sqrt(68.0), 1e-5);
  // A half turn about z through the axis: the same place in the object's own axes, seen on the other side.
  TransformKey half_turn;
  half_turn.rotate_axis = {0, 0, 1};
  half_turn.rotate_radians = M_PI;
  scene.objects[0].transform.keys = {half_turn};
  EXPECT_NEAR(color_at(15), 0.5 + 0.4 * c1 * 2.0 / std::sqrt(68.0), 1e-5);
  scene.objects[0].transform.keys[0].translate = {4, 0, 0};
  EXPECT_NEAR(color_at(48), 0.5 - 0.4 * c1 * 2.0 / std::sqrt(68.0), 1e-5);
}

TEST(SplatReference, WhatItDoesNotDrawIsAnError) {
  Scene scene = one_splat({0, 0, 8}, 0.5f, 1.0f, 1.0f);
  scene.shutter.row_delay = 0.01;
  EXPECT_EQ(render_splat_reference(scene, {1, 0}).error().field, "/shutter/row_delay");
  scene.shutter.row_delay = 0.0;
  scene.objects.push_back(scene.objects[0]);
  EXPECT_TRUE(render_splat_reference(scene, {1, 0}).ok());
  scene.objects[1].splats.colors = SplatColors::linear;
  EXPECT_FALSE(render_splat_reference(scene, {1, 0}).ok());
  EXPECT_FALSE(render_splat_reference(scene, {0, 0}).ok());
}

}  // namespace
}  // namespace swept
