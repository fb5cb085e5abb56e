// Surfels at rest and between keys: validation, interpolation, and the rotation that aligns axes.
#include "splat/surfel.h"

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace {

using namespace swept;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

SurfelPose random_pose(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> in(-1.0f, 1.0f);
  SurfelPose pose;
  for (std::size_t i = 0; i < count; ++i) {
    pose.position.emplace_back(in(random), in(random), in(random));
    pose.axis_u.emplace_back(in(random), in(random), in(random));
    pose.axis_v.emplace_back(in(random), in(random), in(random));
  }
  return pose;
}

using Axes = Eigen::Matrix<double, 3, 2>;
Axes axes_of(const SurfelPose& pose, std::size_t i) {
  Axes a;
  a << pose.axis_u[i].cast<double>(), pose.axis_v[i].cast<double>();
  return a;
}
void set_axes(SurfelPose& pose, std::size_t i, const Axes& a) {
  pose.axis_u[i] = a.col(0).cast<float>();
  pose.axis_v[i] = a.col(1).cast<float>();
}
Eigen::Matrix2d turn(double degrees) { return Eigen::Rotation2Dd(degrees * M_PI / 180.0).toRotationMatrix(); }

SurfelCloud valid_cloud() {
  SurfelCloud cloud;
  cloud.keys = {{1.0, random_pose(3, 1)}, {2.5, random_pose(3, 2)}};
  cloud.color.assign(3, Eigen::Vector3f::Ones());
  cloud.opacity.assign(3, 0.5f);
  return cloud;
}

TEST(SurfelCloudTest, ValidationNamesTheArrayAndTheIndex) {
  ASSERT_TRUE(valid_cloud().validate().ok());
  ASSERT_TRUE(SurfelCloud{}.validate().ok());
  const struct {
    std::function<void(SurfelCloud&)> spoil;
    const char* field;
  } cases[] = {
      {[](auto& c) { c.keys[1].pose.position[2].y() = std::numeric_limits<double>::infinity(); },
       "keys[1].pose.position[2]"},
      {[](auto& c) { c.keys[0].pose.axis_u[1].x() = kNan; }, "keys[0].pose.axis_u[1]"},
      {[](auto& c) { c.keys[0].pose.axis_v[0].z() = kNan; }, "keys[0].pose.axis_v[0]"},
      {[](auto& c) { c.keys[1].pose.axis_v.pop_back(); }, "keys[1].pose.axis_v"},
      {[](auto& c) { c.keys[1].pose = random_pose(2, 3); }, "keys[1].pose.position"},
      {[](auto& c) { c.keys[1].frame = 1.0; }, "keys[1].frame"},
      {[](auto& c) { c.keys[0].frame = std::nan(""); }, "keys[0].frame"},
      {[](auto& c) { c.velocity.assign(3, Eigen::Vector3f::Zero()); }, "velocity"},
      {[](auto& c) {
         c.keys.pop_back();
         c.velocity.assign(3, Eigen::Vector3f(0.0f, kNan, 0.0f));
       },
       "velocity[0]"},
      {[](auto& c) { c.color.pop_back(); }, "color"},
      {[](auto& c) { c.color[2].x() = kNan; }, "color[2]"},
      {[](auto& c) { c.opacity.push_back(1.0f); }, "opacity"},
      {[](auto& c) { c.opacity[1] = 1.5f; }, "opacity[1]"},
      {[](auto& c) { c.opacity[1] = kNan; }, "opacity[1]"},
      {[](auto& c) { c.keys.clear(); }, "color"},
  };
  for (const auto& [spoil, field] : cases) {
    SurfelCloud cloud = valid_cloud();
    spoil(cloud);
    const Status status = cloud.validate();
    ASSERT_FALSE(status.ok()) << field;
    EXPECT_EQ(status.error().field, field);
    EXPECT_FALSE(status.error().reason.empty());
  }
}

TEST(SurfelAtTest, KeysAreHitExactlyJoinedLinearlyAndHeldOutside) {
  SurfelCloud cloud;
  cloud.keys = {{1.0, random_pose(1, 1)}, {2.5, random_pose(1, 2)}, {3.0, random_pose(1, 3)}};
  const auto position = [&](double frame) { return surfel_at(cloud, 0, frame).position; };
  for (const SurfelKey& key : cloud.keys) {
    const SurfelInstant at = surfel_at(cloud, 0, key.frame);
    EXPECT_EQ(at.position, key.pose.position[0]);
    EXPECT_EQ(at.axis_u, key.pose.axis_u[0].cast<double>());
    EXPECT_EQ(at.axis_v, key.pose.axis_v[0].cast<double>());
  }
  EXPECT_EQ(position(-7.0), cloud.keys[0].pose.position[0]);
  EXPECT_EQ(position(99.0), cloud.keys[2].pose.position[0]);
  // A third of the way; numbers up to 1 and three roundings: 4 ulp of 1.
  const SurfelInstant third = surfel_at(cloud, 0, 1.5);
  const auto expect_third = [](const Eigen::Vector3d& at, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b) {
    EXPECT_LE((at - (2.0 * a + b) / 3.0).cwiseAbs().maxCoeff(), 0x1p-50);
  };
  const SurfelPose &a = cloud.keys[0].pose, &b = cloud.keys[1].pose;
  expect_third(third.position, a.position[0], b.position[0]);
  expect_third(third.axis_u, a.axis_u[0].cast<double>(), b.axis_u[0].cast<double>());
  expect_third(third.axis_v, a.axis_v[0].cast<double>(), b.axis_v[0].cast<double>());
}

TEST(SurfelAtTest, WhatKeysShareKeepsItsBits) {
  SurfelCloud cloud;
  cloud.keys = {{0.0, random_pose(1, 1)}, {0.7, random_pose(1, 1)}};
  for (const double frame : {0.1, 0.23456789, 0.6999}) {
    EXPECT_EQ(surfel_at(cloud, 0, frame).position, cloud.keys[0].pose.position[0]);
  }
}

TEST(SurfelAtTest, VelocityCountsFromTheKeysFrame) {
  SurfelCloud cloud;
  cloud.keys = {{10.0, random_pose(1, 1)}};
  EXPECT_EQ(surfel_at(cloud, 0, 4.0).position, cloud.keys[0].pose.position[0]);
  cloud.keys[0].pose.position[0] = {5.4e6, 1.0, 2.0};
  cloud.velocity = {{0.5f, -2.0f, 0.25f}};
  EXPECT_EQ(surfel_at(cloud, 0, 10.0).position, Eigen::Vector3d(5.4e6, 1.0, 2.0));
  EXPECT_EQ(surfel_at(cloud, 0, 12.0).position, Eigen::Vector3d(5.4e6 + 1.0, -3.0, 2.5));
  EXPECT_EQ(surfel_at(cloud, 0, 9.5).position, Eigen::Vector3d(5.4e6 - 0.25, 2.0, 1.875));
}

TEST(AlignAxesTest, RecoversARotationWithinThePlane) {
  const SurfelPose reference = random_pose(200, 7);
  for (const double degrees : {40.0, -170.0, 90.0, 179.9}) {
    SurfelPose moving = reference;
    for (std::size_t i = 0; i < moving.size(); ++i)
      set_axes(moving, i, axes_of(reference, i) * turn(degrees));
    align_axes(reference, moving);
    for (std::size_t i = 0; i < moving.size(); ++i) {
      // Rounded to float before and after: half an ulp of each entry each time, and the angle takes up no
      // more than the first of them again.
      const double error = (axes_of(moving, i) - axes_of(reference, i)).norm();
      ASSERT_LE(error, 3.0 * 0x1p-24 * axes_of(reference, i).norm()) << degrees << " degrees, disc " << i;
    }
  }
}

TEST(AlignAxesTest, LeavesTheDiscAloneAndNoRotationDoesBetter) {
  const SurfelPose reference = random_pose(100, 11), before = random_pose(100, 12);
  SurfelPose after = before;
  align_axes(reference, after);
  for (std::size_t i = 0; i < after.size(); ++i) {
    const Axes a = axes_of(before, i), b = axes_of(after, i), r = axes_of(reference, i);
    const double rounding = 0x1p-24 * a.norm();  // of b, in the Frobenius norm
    // The disc {A w : |w| ≤ 1} is A Aᵀ; its front is a₁ × a₂.
    ASSERT_LE((a * a.transpose() - b * b.transpose()).norm(), 3.0 * a.norm() * rounding);
    ASSERT_LE((a.col(0).cross(a.col(1)) - b.col(0).cross(b.col(1))).norm(), 3.0 * a.norm() * rounding);
    for (int degrees = 0; degrees < 360; ++degrees) {
      ASSERT_LE((b - r).norm(), (a * turn(degrees) - r).norm() + 2.0 * rounding) << degrees;
    }
  }
}

TEST(AlignAxesTest, DegenerateDiscsStayFinite) {
  SurfelPose reference = random_pose(2, 1), moving = random_pose(2, 2);
  set_axes(moving, 0, Axes::Zero());
  set_axes(reference, 1, Axes::Zero());
  const SurfelPose before = moving;
  align_axes(reference, moving);
  EXPECT_EQ(axes_of(moving, 0), axes_of(before, 0));
  EXPECT_EQ(axes_of(moving, 1), axes_of(before, 1));
}

}  // namespace
