// The reference on whole scenes: when it takes one still image, and how its two motions relate.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/reference/reference.h"
#include "tests/counter.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using test::counter;

/// A sphere of discs, 96 × 64 px, that does not move yet.
Scene sphere() {
  Scene scene;
  scene.film = {96, 64, 0, 0, 0, 0};
  scene.camera.look_ats.emplace_back();
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  scene.shutter = {-0.5, 0.5};
  Object object;
  SurfelPose pose;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 400; ++i) {
    const Vector3d out = Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Vector3d side = out.unitOrthogonal();
    pose.position.push_back(out);
    pose.axis_u.push_back((0.2 * side).cast<float>());
    pose.axis_v.push_back((0.2 * out.cross(side)).cast<float>());
    object.cloud.color.push_back(out.cwiseAbs().cast<float>());
  }
  object.cloud.keys.push_back({0.0, std::move(pose)});
  scene.objects.push_back(std::move(object));
  return scene;
}

TransformTrack from_to(const TransformKey& open, const TransformKey& close) {
  TransformTrack track{{open, close}};
  track.keys.front().frame = -0.5;
  track.keys.back().frame = 0.5;
  return track;
}

TransformKey turned(double radians) {
  TransformKey key;
  key.rotate_radians = radians;
  return key;
}

Rendered render(const Scene& scene, ReferenceMotion motion, int samples = 32) {
  auto rendered = render_reference(scene, {samples, motion});
  EXPECT_TRUE(rendered.ok()) << rendered.error().message();
  return std::move(rendered).value();
}

double rmse(const Image& a, const Image& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    squares += std::pow(static_cast<double>(a.rgba[i]) - static_cast<double>(b.rgba[i]), 2);
  }
  return std::sqrt(squares / static_cast<double>(a.rgba.size()));
}

TEST(ReferenceMotion, WhatDoesNotMoveTakesOneStillImage) {
  const Scene still = sphere();
  Scene closed = sphere();
  closed.objects[0].transform = from_to(turned(-0.4), turned(0.4));  // not turned at all in the middle
  closed.shutter = {0.0, 0.0};
  const Rendered expected = render(still, ReferenceMotion::segments);
  EXPECT_EQ(counter(expected, "samples"), 1.0);
  EXPECT_EQ(counter(expected, "instants"), 1.0);
  EXPECT_GT(*std::max_element(expected.image.rgba.begin(), expected.image.rgba.end()), 0.5f);
  for (const Scene* scene : {&still, &std::as_const(closed)}) {
    for (const ReferenceMotion motion : {ReferenceMotion::segments, ReferenceMotion::smooth}) {
      const Rendered rendered = render(*scene, motion);
      EXPECT_EQ(counter(rendered, "instants"), 1.0);
      EXPECT_EQ(rendered.image.rgba, expected.image.rgba);
      EXPECT_EQ(rendered.image.depth, expected.image.depth);
    }
  }
}

TEST(ReferenceMotion, TurningOnTheSpotIsMotion) {
  Scene scene = sphere();
  scene.model.segments = 4;
  scene.objects[0].cloud.keys[0].pose.position.assign(400, Vector3d::Zero());
  scene.objects[0].transform = from_to(turned(0.0), turned(1.0));
  for (const ReferenceMotion motion : {ReferenceMotion::segments, ReferenceMotion::smooth}) {
    const Rendered rendered = render(scene, motion);
    EXPECT_EQ(counter(rendered, "samples"), 32.0);
    EXPECT_EQ(counter(rendered, "instants"), 48.0);
    // Kernels that stand still for a quarter of the shutter are the same 8 times or 4 times out of it.
    // What remains is rounding to floats.
    EXPECT_EQ(counter(rendered, "reference_error_rmse") > 0x1p-24, motion == ReferenceMotion::smooth);
  }
}

TEST(ReferenceMotion, StraightPathIsItsOwnSegment) {
  Scene scene = sphere();
  scene.model.filter_radius_px = 0.0;  // the filter alone would change along the path
  TransformKey open, close;
  open.translate = {-0.7, -0.2, 0.4};
  close.translate = {0.8, 0.3, -0.6};
  scene.objects[0].transform = from_to(open, close);
  const Image segments = render(scene, ReferenceMotion::segments).image;
  const Image smooth = render(scene, ReferenceMotion::smooth).image;
  for (std::size_t i = 0; i < segments.rgba.size(); ++i) {
    // Two floats that round values at most 1 which agree to a few ulp of double.
    ASSERT_NEAR(segments.rgba[i], smooth.rgba[i], 0x1p-23) << i;
  }
}

TEST(ReferenceMotion, MoreSegmentsComeCloserToTheTruePath) {
  Scene scene = sphere();
  scene.objects[0].transform = from_to(turned(0.0), turned(1.5));
  // 5 instants to the shortest segment: an odd number puts none of them where two segments meet.
  constexpr int samples = 5 * 64;
  const auto distance = [&, smooth = render(scene, ReferenceMotion::smooth, samples).image](int segments) {
    scene.model.segments = segments;
    const double error = rmse(render(scene, ReferenceMotion::segments, samples).image, smooth);
    RecordProperty("rmse_" + std::to_string(segments), std::to_string(error));
    return error;
  };
  const double of_1 = distance(1), of_8 = distance(8), of_64 = distance(64);
  // Chords err by the inverse square of their number, frozen axes by no more than its inverse: a factor of 8
  // or more. Half of that is asked, for coverage ends in jumps, which a finite number of instants blurs.
  EXPECT_GT(of_64, 0.0);
  EXPECT_LT(of_8, of_1 / 4.0);
  EXPECT_LT(of_64, of_8 / 4.0);
}

TEST(ReferenceMotion, OrderOfPointsChangesNoBit) {
  Scene scene = sphere();
  scene.objects[0].transform = from_to(turned(0.0), turned(0.5));
  const Image image = render(scene, ReferenceMotion::segments).image;
  test::reverse_points(scene.objects[0].cloud);
  const Image reversed = render(scene, ReferenceMotion::segments).image;
  EXPECT_EQ(image.rgba, reversed.rgba);
  EXPECT_EQ(image.depth, reversed.depth);
}

TEST(ReferenceMotion, BadSceneIsRefused) {
  Scene scene = sphere();
  scene.objects[0].cloud.color.pop_back();
  for (const ReferenceMotion motion : {ReferenceMotion::segments, ReferenceMotion::smooth}) {
    EXPECT_FALSE(render_reference(scene, {2, motion}).ok());
  }
}

}  // namespace
}  // namespace swept
