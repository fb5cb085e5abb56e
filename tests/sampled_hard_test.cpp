// The sampled engine on hard cases, each against the reference at the same instants of the true path.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "abuffer/reference/reference.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/oracle/hard_scenes.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

/// Finite, and within what a picture may hold.
void expect_sound(const Image& image) {
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) ASSERT_TRUE(std::isfinite(image.rgba[4 * i + c]));
    ASSERT_GE(image.rgba[4 * i + 3], 0.0f);
    ASSERT_LE(image.rgba[4 * i + 3], 1.0f + 1e-6f);
    ASSERT_GT(image.depth[i], 0.0f);
  }
}

/// PSNR of colour and alpha without a background.
double reference_db(Scene scene, int samples) {
  scene.background.setZero();
  const Rendered rendered = test::rendered(scene, samples);
  expect_sound(rendered.image);
  const auto reference = render_reference(scene, {samples, ReferenceMotion::smooth});
  EXPECT_TRUE(reference.ok()) << reference.error().message();
  if (!reference.ok()) return 0.0;
  const double off = test::difference_of(rendered.image, reference->image).color;
  return -20.0 * std::log10(std::max(off, 1e-9));
}

void expect_reference(const Scene& scene, int samples, double least_db, const std::string& what = "") {
  const double db = reference_db(scene, samples);
  EXPECT_GE(db, least_db) << what;
}

class SampledHardScene : public testing::TestWithParam<oracle::HardScene> {};

TEST_P(SampledHardScene, IsTheReference) {
  const oracle::HardScene& hard = GetParam();
  expect_reference(hard.make(), 24, 90.0, hard.name);
}

INSTANTIATE_TEST_SUITE_P(HardScenes, SampledHardScene, testing::ValuesIn(oracle::hard_scenes()),
                         [](const auto& param) {
                           std::string name = param.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

Scene ball() {
  Scene scene = test::stage();
  scene.objects = {test::checkered_sphere(1.0, 500)};
  test::move(scene.objects[0], {-0.4, 0.0, 0.0}, {0.5, 0.2, 0.5}, 1.0);
  return scene;
}

TEST(SampledHard, NumbersNearTheEndsOfTheirRanges) {
  const auto with = [](const auto& change) {
    Scene scene = ball();
    change(scene);
    return scene;
  };
  expect_reference(with([](Scene& s) { s.model.delta = 50.0; }), 4, 90.0, "delta 50");
  expect_reference(with([](Scene& s) { s.model.delta = 1e-3; }), 4, 90.0, "delta 0.001");
  expect_reference(with([](Scene& s) { s.model.depth_tolerance = 0.0; }), 4, 60.0, "tolerance 0");
  expect_reference(with([](Scene& s) { s.model.depth_tolerance = 100.0; }), 4, 90.0, "tolerance 100");
  expect_reference(with([](Scene& s) { s.model.filter_radius_px = 0.0; }), 4, 90.0, "filter 0");
  expect_reference(with([](Scene& s) { s.model.filter_radius_px = 100.0; }), 4, 90.0, "filter 100");
  expect_reference(with([](Scene& s) { s.model.edge_weight = 0x1p-15; }), 4, 80.0, "edge weight least");
  expect_reference(with([](Scene& s) { s.model.coverage = Coverage::hard; }), 4, 80.0, "hard");
  for (const float opacity : {0.0f, 1e-3f, 0.999f})
    expect_reference(with([&](Scene& s) { s.objects[0].cloud.opacity.assign(500, opacity); }), 4, 90.0,
                     "opacity " + std::to_string(opacity));
  expect_reference(with([](Scene& s) { s.camera.near = 4.5; }), 4, 80.0, "cut by the near plane");
  expect_reference(with([](Scene& s) { s.film = {1, 1, 0, 0, 0, 0}; }), 4, 90.0, "film 1x1");
  expect_reference(with([](Scene& s) { s.film = {3, 200, 0, 0, 0, 0}; }), 4, 90.0, "film 3x200");
}

TEST(SampledHard, ScalesThatAreNegativeFlatOrVast) {
  for (const Eigen::Vector3d& scale :
       {Eigen::Vector3d(-1.0, 1.0, 1.0), Eigen::Vector3d(-1.0, -0.5, -2.0), Eigen::Vector3d(1.0, 1e-6, 1.0),
        Eigen::Vector3d(1.0, 0.0, 1.0), Eigen::Vector3d(1e3, 1e3, 1e3), Eigen::Vector3d(1e-4, 1e-4, 1e-4)})
    for (const bool two_sided : {true, false}) {
      Scene scene = ball();
      for (TransformKey& key : scene.objects[0].transform.keys) key.scale = scale;
      scene.objects[0].two_sided = two_sided;
      expect_reference(scene, 4, 80.0,
                       "scale " + std::to_string(scale.x()) + " " + std::to_string(scale.y()));
    }
  // Through zero.
  Scene scene = ball();
  scene.objects[0].transform.keys[1].scale = {-1.0, 1.0, 1.0};
  expect_reference(scene, 8, 80.0, "through zero");
}

TEST(SampledHard, ScenesOfAnySize) {
  for (const double size : {1e-12, 1e-6, 1e6, 1e12, 1e25}) {
    Scene scene = ball();
    for (SurfelKey& key : scene.objects[0].cloud.keys) {
      for (Eigen::Vector3d& p : key.pose.position) p *= size;
      for (Eigen::Vector3f& a : key.pose.axis_u) a *= static_cast<float>(size);
      for (Eigen::Vector3f& a : key.pose.axis_v) a *= static_cast<float>(size);
    }
    for (TransformKey& key : scene.objects[0].transform.keys) key.translate *= size;
    for (LookAtKey& key : scene.camera.look_ats) key.eye *= size, key.target *= size;
    scene.camera.near *= size;
    expect_reference(scene, 4, 90.0, "size " + std::to_string(std::log10(size)));
  }
}

/// One packet holds what is near the eye and what is a thousand or a million times as far.
TEST(SampledHard, NeighboursFarApartInDepth) {
  for (const double far : {1e2, 1e4, 1e6, 1e9, 1e14, 1e30}) {
    Scene scene = test::stage();
    scene.film = {320, 240, 0, 0, 0, 0};
    Object& object = scene.objects.emplace_back();
    test::Random random(1);
    for (int i = 0; i < 8; ++i) {
      test::add_disc(object, random.vector(-1.0, 1.0), random.vector(-1.0, 1.0).normalized(), 0.3,
                     random.vector(0.0, 1.0).cast<float>());
      test::add_disc(object, {0.1 * far * i, 0.1 * far, -far}, Eigen::Vector3d::UnitZ(), 0.1 * far,
                     random.vector(0.0, 1.0).cast<float>());
    }
    test::move(object, {0.0, 0.0, 0.0}, {0.3, 0.2, 0.1});
    expect_reference(scene, 4, 90.0, "far " + std::to_string(std::log10(far)));
  }
}

TEST(SampledHard, AnyNumberOfPointsAndObjects) {
  for (const int points : {1, 2, 15, 16, 17, 33}) {
    Scene scene = ball();
    scene.objects.insert(scene.objects.begin(), Object{});
    scene.objects[1].cloud = test::checkered_sphere(1.0, points).cloud;
    expect_reference(scene, 4, 90.0, std::to_string(points) + " points");
  }
  Scene empty = test::stage();
  expect_sound(test::rendered(empty, 4).image);
  empty.objects.resize(2);
  expect_sound(test::rendered(empty, 0).image);
}

TEST(SampledHard, KeysOutsideTheExposureAndAtItsEnds) {
  for (const auto& [first, last] : {std::pair(-9.0, -8.0), std::pair(8.0, 9.0), std::pair(-1.0, 0.0),
                                    std::pair(0.0, 1.0), std::pair(1.0, 2.0), std::pair(-5.0, 5.0)}) {
    Scene scene = ball();
    SurfelCloud& cloud = scene.objects[0].cloud;
    cloud.keys.push_back(cloud.keys[0]);
    for (Eigen::Vector3d& p : cloud.keys[1].pose.position) p.x() += 1.0;
    cloud.keys[0].frame = first, cloud.keys[1].frame = last;
    expect_reference(scene, 6, 90.0, "keys from " + std::to_string(first));
    scene.shutter = {0.5, 0.5};
    expect_reference(scene, 6, 90.0, "closed, keys from " + std::to_string(first));
  }
}

TEST(SampledHard, CamerasThatTurnZoomAndPassByTheirTarget) {
  Scene scene = ball();
  scene.film = {200, 140, 0, 0, 0, 0};
  scene.camera.near = 0.01;
  scene.camera.look_ats.resize(2);
  scene.camera.look_ats[1].frame = 1.0;
  scene.camera.look_ats[1].tan_half_fov_y = 0.05;
  expect_reference(scene, 8, 90.0, "zoom");
  scene.camera.look_ats[1].tan_half_fov_y = 0.5;
  for (const double distance : {1.7, 1.1, 0.3, 0.01}) {
    scene.camera.look_ats[0].eye = {-3.0, 0.0, distance};
    scene.camera.look_ats[1].eye = {2.0, 0.0, distance};
    expect_reference(scene, 32, 85.0, "passing at " + std::to_string(distance));
  }
}

/// Cells far from where a thing is at the exposure's middle.
TEST(SampledHard, WhatFliesPastTheEye) {
  for (int i = 0; i < 6; ++i) {
    Scene scene = test::stage();
    scene.film = {300, 200, 0, 0, 0, 0};
    scene.objects = {test::checkered_sphere(0.2, 100)};
    test::move(scene.objects[0], {0.1 * i, 0.05 * i - 0.2, 6.0}, {0.4 - 0.3 * i, 0.3, -4.0 - i});
    expect_reference(scene, 64, 85.0, "flight " + std::to_string(i));
  }
}

/// Were it quadratic it would take minutes.
TEST(SampledHard, AHundredThousandEqualPoints) {
  Scene scene = test::stage();
  scene.film = {16, 12, 0, 0, 0, 0};
  Object& object = scene.objects.emplace_back();
  for (int i = 0; i < 100000; ++i)
    test::add_disc(object, {0.1, 0.1, 0.0}, Eigen::Vector3d::UnitZ(), 0.5, {0.5f, 0.25f, 1.0f});
  const Image opaque = test::rendered(scene, 2).image;
  expect_sound(opaque);
  object.cloud.opacity.assign(100000, 0.5f);
  expect_sound(test::rendered(scene, 2).image);
  // Inside the disc the surface's colour, but for 10⁵ roundings of 2⁻²⁴ each, were they all to one side.
  const float expected[4] = {0.5f, 0.25f, 1.0f, 1.0f};
  for (std::size_t c = 0; c < 4; ++c)
    EXPECT_NEAR(opaque.rgba[4 * (6 * 16 + 8) + c], expected[c], 1e5 * 0x1p-24);
}

TEST(SampledHard, AFilmOfOneRow) {
  Scene scene = ball();
  scene.film = {65536, 1, 0, 0, 0, 0};
  expect_sound(test::rendered(scene, 2).image);
  expect_sound(test::rendered(scene, 0).image);
  scene.film = {1, 65536, 0, 0, 0, 0};
  expect_sound(test::rendered(scene, 2).image);
}

TEST(SampledHard, CropsAtTheFilmsBorders) {
  Scene scene = ball();
  scene.film = {130, 67, 0, 0, 0, 0};
  const Image whole = test::rendered(scene, 3).image;
  for (const auto& [x, y, width, height] :
       {std::array{0, 0, 1, 1}, std::array{129, 66, 1, 1}, std::array{64, 0, 66, 67},
        std::array{0, 64, 130, 3}, std::array{63, 63, 2, 2}}) {
    scene.film.crop_x = x, scene.film.crop_y = y;
    scene.film.crop_width = width, scene.film.crop_height = height;
    const Image crop = test::rendered(scene, 3).image;
    EXPECT_TRUE(test::is_crop_of(crop, whole, scene.film));
  }
}

}  // namespace
}  // namespace swept
