#include "tools/study/raycast.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "tests/counter.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using test::add_disc;
using test::counter;
using test::Random;

constexpr float background[4] = {0.1f, 0.2f, 0.3f, 1.0f};

Scene stage() {
  Scene scene = test::stage();
  scene.background = Eigen::Vector4f(background);
  return scene;
}

Scene spheres() {
  Scene scene = test::busy_scene();
  scene.background = Eigen::Vector4f(background);
  return scene;
}

Scene translucent_particles() {
  Scene scene = stage();
  Random random(5);
  Object object;
  for (int i = 0; i < 1500; ++i) {
    add_disc(object, random.vector(-2, 2), random.vector(-1, 1).normalized(), random(0.01, 0.08),
             random.vector(0, 1).cast<float>());
    object.cloud.velocity.push_back(random.vector(-1, 1).cast<float>());
    object.cloud.opacity.push_back(static_cast<float>(random(0.3, 1.0)));
  }
  scene.objects = {object};
  return scene;
}

/// Discs fly at the eye, through the near plane.
Scene fly_past() {
  Scene scene = stage();
  scene.camera.near = 0.05;
  Object object;
  Random random(9);
  for (int i = 0; i < 60; ++i) {
    add_disc(object, {random(-0.5, 0.5), random(-0.5, 0.5), random(3.0, 4.8)},
             random.vector(-1, 1).normalized(), 0.15, random.vector(0, 1).cast<float>());
  }
  object.cloud.velocity.assign(object.cloud.size(), Eigen::Vector3f(0.0f, 0.0f, 2.0f));
  scene.objects = {object};
  return scene;
}

/// One large disc before the eye, at the given depth.
Scene wall(double depth, const Vector3d& normal = Vector3d::UnitZ()) {
  Scene scene = stage();
  Object object;
  add_disc(object, {0.0, 0.0, 5.0 - depth}, normal, 20.0 * depth);
  scene.objects = {object};
  return scene;
}

Rendered cast(const Scene& scene, const RaycastOptions& options = {}) {
  Result<Rendered> rendered = render_raycast(scene, options);
  EXPECT_TRUE(rendered.ok()) << rendered.error().message();
  return std::move(rendered).value();
}

/// Of the segments that rays meet.
Image exact(const Scene& scene) {
  Result<Rendered> rendered = render_abuffer(scene, {.parabolas = false});
  EXPECT_TRUE(rendered.ok()) << rendered.error().message();
  return std::move(rendered).value().image;
}

/// Of RGBA: root of the mean square, and mean.
struct Difference {
  double rms = 0.0, mean = 0.0, largest = 0.0;
  explicit Difference(const Image& a, const Image& b) {
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
      const double d = static_cast<double>(a.rgba[i]) - static_cast<double>(b.rgba[i]);
      rms += d * d;
      mean += d;
      largest = std::max(largest, std::abs(d));
    }
    rms = std::sqrt(rms / static_cast<double>(a.rgba.size()));
    mean /= static_cast<double>(a.rgba.size());
  }
};

class Raycast : public testing::Test {
 protected:
  void SetUp() override {
    if (!raycast_available()) GTEST_SKIP() << "built without Embree";
  }
};

/// A signal that jumps once errs by at most a stratum's share, whose width goes with 1/n, and no smoother
/// signal gains less from more rays. Sixteen times as many leave 1/16; drawing without
/// strata would leave 1/4. Between the two, 1/9, and what the exact image itself is off by: 2⁻¹⁵ root mean
/// square (90 dB) at most, as tools/accuracy finds it.
///
/// Rays know no bias: the mean over P pixels, whose offsets are independent of each other, is off by the
/// error of one over √P, in standard deviations. Its four channels hang together, which the factor 2 allows
/// for.
void expect_convergence(const Scene& scene, Offsets offsets = Offsets::shared) {
  constexpr double kExact = 0x1p-15;
  const Image image = exact(scene);
  const Difference at_16(cast(scene, {16, 2, 1, offsets}).image, image),
      at_256(cast(scene, {256, 2, 1, offsets}).image, image);
  EXPECT_GT(at_16.rms, 0.0);
  EXPECT_LE(at_256.rms, at_16.rms / 9.0 + kExact);
  const double pixels = static_cast<double>(image.pixel_count());
  for (const Difference& difference : {at_16, at_256})
    EXPECT_LE(std::abs(difference.mean), 4.0 * 2.0 * difference.rms / std::sqrt(pixels) + kExact);
}

TEST_F(Raycast, ConvergesToTheExactImage) { expect_convergence(spheres()); }
TEST_F(Raycast, ConvergesOnTranslucentParticles) { expect_convergence(translucent_particles()); }
TEST_F(Raycast, ConvergesThroughTheNearPlane) { expect_convergence(fly_past()); }

TEST_F(Raycast, ConvergesWithIndependentOffsets) {
  const Scene scene = spheres();
  expect_convergence(scene, Offsets::independent);
  EXPECT_NE(cast(scene, {8, 2, 1, Offsets::independent}).image.rgba, cast(scene, {8, 2}).image.rgba);
}

TEST_F(Raycast, ConvergesUnderHardCoverage) {
  Scene scene = spheres();
  scene.model.coverage = Coverage::hard;
  expect_convergence(scene);
}

TEST_F(Raycast, ConvergesOnOneSidedSurfaces) {
  Scene scene = spheres();
  for (Object& object : scene.objects) object.two_sided = false;
  expect_convergence(scene);
}

TEST_F(Raycast, OneRayIsTheStillImageWhereNothingMoves) {
  for (Scene scene : {spheres(), translucent_particles(), fly_past()}) {
    scene.shutter.close = scene.shutter.open;
    const Rendered rendered = cast(scene, {64, 2});
    EXPECT_EQ(counter(rendered, "samples"), 1.0);
    EXPECT_EQ(counter(rendered, "rays"), 64.0 * 48.0);
    // The same fragments through the same code. Their coordinates are double precision on both sides, and
    // (u, v) the same expression: a float may round the other way, which is 2⁻²³ of a sum that is below 1,
    // a hundred times over at most.
    const Difference difference(rendered.image, exact(scene));
    EXPECT_LE(difference.largest, 100 * 0x1p-23);
  }
}

TEST_F(Raycast, ThreadsChangeNoBitAndSeedsDo) {
  for (const Scene& scene : {spheres(), translucent_particles()}) {
    const Image one = cast(scene, {8, 1}).image, two = cast(scene, {8, 2}).image;
    EXPECT_EQ(one.rgba, two.rgba);
    EXPECT_EQ(one.depth, two.depth);
    EXPECT_NE(one.rgba, cast(scene, {8, 2, 2}).image.rgba);
  }
}

TEST_F(Raycast, CropEqualsThosePixelsOfTheFrame) {
  Scene scene = spheres();
  const Image whole = cast(scene, {4, 2}).image;
  scene.film = {64, 48, 20, 12, 24, 17};
  const Image crop = cast(scene, {4, 2}).image;
  ASSERT_EQ(crop.rgba.size(), 4u * 24u * 17u);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 24 * 4; ++x) {
      EXPECT_EQ(crop.rgba[static_cast<std::size_t>(y * 24 * 4 + x)],
                whole.rgba[static_cast<std::size_t>(((y + 12) * 64 + 20) * 4 + x)]);
    }
  }
}

TEST_F(Raycast, OneSidedDiscsAreSeenFromTheirFrontOnly) {
  for (const double side : {1.0, -1.0}) {
    Scene scene = wall(2.0, side * Vector3d::UnitZ());
    scene.background.setZero();
    scene.objects[0].two_sided = false;
    const Image image = cast(scene).image;
    for (std::size_t p = 0; p < image.pixel_count(); ++p)
      EXPECT_NEAR(image.rgba[4 * p + 3], side > 0.0 ? 1.0 : 0.0, 0x1p-23);
  }
}

TEST_F(Raycast, NothingIsSeenBeforeTheNearPlane) {
  for (const double depth : {0.4999, 0.5001}) {
    Scene scene = wall(depth);
    scene.background.setZero();
    scene.camera.near = 0.5;
    const Image image = cast(scene).image;
    for (std::size_t p = 0; p < image.pixel_count(); ++p) {
      EXPECT_NEAR(image.rgba[4 * p + 3], depth > 0.5 ? 1.0 : 0.0, 0x1p-23);
      if (depth > 0.5) {
        EXPECT_NEAR(image.depth[p], depth, 1e-6);
      }
    }
  }
}

TEST_F(Raycast, SegmentsMeetWithoutGapOrOverlap) {
  // Half transparent, so that what is met twice shows as much as what is not met at all.
  Scene scene = wall(3.0);
  scene.background.setZero();
  scene.model.segments = 7;
  scene.objects[0].cloud.opacity = {0.5f};
  scene.objects[0].cloud.velocity = {Eigen::Vector3f(0.5f, 0.25f, 0.1f)};
  const Rendered rendered = cast(scene, {128, 2});
  EXPECT_EQ(counter(rendered, "motion_ranges"), 7.0);
  EXPECT_EQ(counter(rendered, "hits"), counter(rendered, "rays"));
  // 128 sums of 0.5, each off by less than 2⁻²³.
  for (std::size_t p = 0; p < rendered.image.pixel_count(); ++p)
    EXPECT_NEAR(rendered.image.rgba[4 * p + 3], 0.5, 0x1p-22);
}

TEST_F(Raycast, WhatOpaqueDiscsHideIsNotMet) {
  Scene scene = stage();
  Object object;
  // Each fills the frame, and the nearest is not the first.
  for (int i = 0; i < 64; ++i) {
    const double depth = 3.0 + (i * 37) % 64;
    add_disc(object, {0.0, 0.0, 5.0 - depth}, Vector3d::UnitZ(), 3.0 * depth);
  }
  scene.model.depth_tolerance = 0.0;  // no two are one surface
  scene.objects = {object};
  const double rays = 64 * 48;
  const Rendered opaque = cast(scene);
  EXPECT_LT(counter(opaque, "hits"), 8 * rays);
  const Image image = exact(scene);
  EXPECT_LE(Difference(opaque.image, image).largest, 100 * 0x1p-23);

  scene.objects[0].cloud.opacity.assign(64, 0.5f);
  const Rendered veils = cast(scene);
  EXPECT_EQ(counter(veils, "hits"), 64 * rays);
  EXPECT_LE(Difference(veils.image, exact(scene)).largest, 100 * 0x1p-23);
}

TEST_F(Raycast, RefusesWhatEmbreeDoesNotSee) {
  Scene scene = wall(2.0);
  scene.objects[0].cloud.keys[0].pose.position[0].x() = 2e18;
  const Result<Rendered> rendered = render_raycast(scene);
  ASSERT_FALSE(rendered.ok());
  EXPECT_NE(rendered.error().message().find("10^18"), std::string::npos);
}

TEST(RaycastOptions, AreChecked) {
  EXPECT_TRUE(RaycastOptions{}.validate().ok());
  EXPECT_EQ((RaycastOptions{0}.validate().error().field), "samples");
  EXPECT_EQ((RaycastOptions{(1 << 20) + 1}.validate().error().field), "samples");
  EXPECT_EQ((RaycastOptions{1, -1}.validate().error().field), "threads");
  EXPECT_EQ((RaycastOptions{1, 1025}.validate().error().field), "threads");
  EXPECT_FALSE(render_raycast(stage(), {0}).ok());
}

TEST(RaycastAvailable, SaysWhetherRaysCanBeCast) {
  const Result<Rendered> rendered = render_raycast(stage());
  EXPECT_EQ(rendered.ok(), raycast_available());
  if (!rendered) {
    EXPECT_NE(rendered.error().message().find("Embree"), std::string::npos);
  }
}

}  // namespace
}  // namespace swept
