#include "splat/motion/segments.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "splat/kernel/kernel_set.h"

namespace swept {
namespace {

/// A ring of points of the given radius around the z axis, 10 units from the eye, focal length 1000 px.
Scene ring(double radius, double degrees_of_turn) {
  Scene scene;
  scene.film = {1000, 1000, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back().eye = {0.0, 0.0, 10.0};
  Object& object = scene.objects.emplace_back();
  SurfelPose& pose = object.cloud.keys.emplace_back().pose;
  for (int i = 0; i < 5000; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 5000.0;
    pose.position.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    pose.axis_u.emplace_back(1e-3f, 0.0f, 0.0f);
    pose.axis_v.emplace_back(0.0f, 1e-3f, 0.0f);
  }
  object.transform.keys.resize(2);
  for (TransformKey& key : object.transform.keys) key.rotate_axis = Eigen::Vector3d::UnitZ();
  object.transform.keys[1].frame = 1.0;
  object.transform.keys[1].rotate_radians = degrees_of_turn * std::numbers::pi / 180.0;
  return scene;
}

/// How far the chord of an arc of `degrees` in n parts stays inside it, px.
double sagitta_px(double radius, double degrees, int parts) {
  return 100.0 * radius * (1.0 - std::cos(degrees * std::numbers::pi / 360.0 / parts));
}

TEST(Segments, KeepThePathWithinATenthOfAPixel) {
  for (const double degrees : {1.0, 5.0, 30.0, 90.0, 180.0, 300.0}) {
    const Scene scene = ring(2.0, degrees);
    const int segments = linear_segments(scene, scene.objects[0], scene.exposure());
    if (segments < max_chosen_segments) {
      EXPECT_LE(sagitta_px(2.0, degrees, segments), 0.1 * 1.001) << degrees;
    }
    // No more than the next count that is tried.
    if (segments > 1) {
      EXPECT_GT(sagitta_px(2.0, degrees, std::max(1, segments / 2 - 1)), 0.1) << degrees;
    }
  }
}

TEST(Segments, SeeATurnThatEndsWhereItBegan) {
  const Scene scene = ring(2.0, 720.0);
  EXPECT_EQ(linear_segments(scene, scene.objects[0], scene.exposure()), max_chosen_segments);
}

TEST(Segments, AreOneOnAStraightPathAndWhereNothingMoves) {
  Scene scene = ring(2.0, 0.0);
  EXPECT_EQ(linear_segments(scene, scene.objects[0], scene.exposure()), 1);
  scene.objects[0].transform.keys[1].translate = {0.5, 0.1, 2.0};
  EXPECT_EQ(linear_segments(scene, scene.objects[0], scene.exposure()), 1);
  scene = ring(2.0, 90.0);
  scene.shutter = {0.3, 0.3};
  EXPECT_EQ(linear_segments(scene, scene.objects[0], scene.exposure()), 1);
}

TEST(Segments, FollowTheSceneWhereItSaysHowMany) {
  Scene scene = ring(2.0, 90.0);
  scene.model.segments = 3;
  EXPECT_EQ(linear_segments(scene, scene.objects[0], scene.exposure()), 3);
  scene.objects[0].segments = 5;
  EXPECT_EQ(linear_segments(scene, scene.objects[0], scene.exposure()), 5);
}

TEST(Segments, HaveTheMeanPositionOfTheirStretchOfThePath) {
  Scene scene = ring(2.0, 90.0);
  scene.model.segments = 3;
  const KernelSet set = build_kernels(scene);
  ASSERT_EQ(set.kernels.size(), 15000u);
  // The mean of an arc's points: R sin(φ/2) / (φ/2) from the centre. Simpson's rule errs by R (φ/2)⁴/180.
  const double half = std::numbers::pi / 12.0, radius = 2.0 * std::sin(half) / half;
  const double simpson = 2.0 * std::pow(half, 4) / 180.0;
  for (const MovingKernel& kernel : set.kernels) {
    ASSERT_NEAR(kernel.center.head<2>().norm(), radius, 1.05 * simpson);
    ASSERT_NEAR(kernel.velocity.norm(), 3.0 * 4.0 * std::sin(half), 1e-9);
  }
  // The chord's own middle is a hundred times as far off.
  ASSERT_GT(std::abs(2.0 * std::cos(half) - radius), 100.0 * simpson);
}

TEST(Segments, DoNotDependOnTheOrderOfThePoints) {
  Scene scene = ring(2.0, 40.0);
  const int segments = linear_segments(scene, scene.objects[0], scene.exposure());
  SurfelPose& pose = scene.objects[0].cloud.keys[0].pose;
  std::reverse(pose.position.begin(), pose.position.end());
  EXPECT_EQ(linear_segments(scene, scene.objects[0], scene.exposure()), segments);
}

}  // namespace
}  // namespace swept
