// What must not change a picture, from the scene on: scale, place, direction of time, who it is that moves.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "splat/kernel/kernel_set.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double unit_roundoff = 0x1p-53;

/// 150 discs around the origin, seen along z from 5 units away; shutter [−½, ½]. Each disc's red is its name.
/// With `grid`, coordinates are multiples of 2⁻²⁰.
Scene discs(bool grid) {
  Scene scene;
  scene.film = {64, 48, 0, 0, 0, 0};
  scene.shutter = {-0.5, 0.5};
  CameraKey pose;
  pose.eye = {0.0, 0.0, -5.0};
  scene.camera.poses.push_back(pose);
  scene.camera.near = 0.125;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto coordinate = [&] { return grid ? std::round(unit(random) * 0x1p20) * 0x1p-20 : unit(random); };
  Object object;
  SurfelPose pose_of_discs;
  for (int i = 0; i < 150; ++i) {
    pose_of_discs.position.emplace_back(coordinate(), coordinate(), coordinate());
    const Vector3d normal = Vector3d(unit(random), unit(random), unit(random)).normalized();
    const Vector3d side = normal.unitOrthogonal();
    pose_of_discs.axis_u.push_back((0.15 * side).cast<float>());
    pose_of_discs.axis_v.push_back((0.1 * normal.cross(side)).cast<float>());
    object.cloud.color.emplace_back(static_cast<float>(i + 1) / 150.0f, 0.5f, 0.25f);
  }
  object.cloud.keys.push_back({0.0, std::move(pose_of_discs)});
  scene.objects.push_back(std::move(object));
  return scene;
}

SurfelPose& pose_of(Scene& scene) { return scene.objects[0].cloud.keys[0].pose; }

void set_velocities(Scene& scene, double sign) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<float> unit(-0.5f, 0.5f);
  for (std::size_t i = 0; i < scene.objects[0].cloud.size(); ++i)
    scene.objects[0].cloud.velocity.push_back(static_cast<float>(sign) *
                                              Vector3f(unit(random), unit(random), unit(random)));
}

std::map<float, MovingKernel> by_name(const KernelSet& set) {
  std::map<float, MovingKernel> kernels;
  for (const MovingKernel& kernel : set.kernels) kernels[kernel.color.x()] = kernel;
  return kernels;
}

/// Centres and velocities agree to `position` and `velocity`, axes to a float's rounding of what that moves.
void expect_same_kernels(const KernelSet& a, const KernelSet& b, double position, double velocity) {
  ASSERT_EQ(a.kernels.size(), b.kernels.size());
  ASSERT_GT(a.kernels.size(), 100u);
  const auto left = by_name(a), right = by_name(b);
  for (const auto& [name, k] : left) {
    ASSERT_TRUE(right.count(name));
    const MovingKernel& other = right.at(name);
    EXPECT_LE((k.center - other.center).cwiseAbs().maxCoeff(), position);
    EXPECT_LE((k.velocity - other.velocity).cwiseAbs().maxCoeff(), velocity);
    // The axes' rotation is free where the disc is round on screen: compare AAᵀ, in which a
    // float's roundings enter twice for each of two axes. A shift turns the line of sight by as much over a
    // depth above 3, Q by |A| of that and the lifted depth by |A|/r ≤ 2.5 more, all twice: 4 times the shift.
    const auto spread = [](const MovingKernel& m) {
      const Vector3d u = m.axis_u.cast<double>(), v = m.axis_v.cast<double>();
      return Eigen::Matrix3d(u * u.transpose() + v * v.transpose());
    };
    const double size = k.axis_u.squaredNorm() + k.axis_v.squaredNorm();
    EXPECT_LE((spread(k) - spread(other)).cwiseAbs().maxCoeff(), (4 * 0x1p-24 + 4 * position) * size);
    EXPECT_NEAR(k.weight, other.weight, 0x1p-23 + 4 * position);
  }
}

/// A position goes through four roundings of numbers up to |p| + |d| + 5 on either way.
TEST(Invariance, MovingTheCameraIsMovingTheObjects) {
  const Vector3d d(0.4, -0.3, 0.7);
  Scene object_moves = discs(false), camera_moves = object_moves;
  TransformKey first, last;
  first.frame = -1.0;
  last.frame = 1.0;
  first.translate = -d;
  last.translate = d;
  object_moves.objects[0].transform.keys = {first, last};
  CameraKey pose = camera_moves.camera.poses[0];
  camera_moves.camera.poses.clear();
  for (const double sign : {-1.0, 1.0}) {
    pose.frame = sign;
    pose.eye = Vector3d(0.0, 0.0, -5.0) - sign * d;
    camera_moves.camera.poses.push_back(pose);
  }
  const double bound = 2 * 4 * unit_roundoff * 8.0;
  expect_same_kernels(build_kernels(object_moves), build_kernels(camera_moves), bound, 2 * bound);
}

/// And turning: rotations about the eye. Matrices from an angle and from quaternions are each within 32 ε:
/// sine, cosine and slerp of a few ε, squared and added in threes.
TEST(Invariance, TurningTheCameraIsTurningTheObjects) {
  const Vector3d axis = Vector3d(0.3, 1.0, -0.2).normalized();
  Scene object_turns = discs(false), camera_turns;
  object_turns.camera.poses[0].eye.setZero();
  for (Vector3d& p : pose_of(object_turns).position) p.z() += 5.0;
  camera_turns = object_turns;
  TransformKey first, last;
  first.frame = -1.0;
  last.frame = 1.0;
  first.rotate_axis = last.rotate_axis = axis;
  first.rotate_radians = -0.1;
  last.rotate_radians = 0.1;
  object_turns.objects[0].transform.keys = {first, last};
  CameraKey pose = camera_turns.camera.poses[0];
  camera_turns.camera.poses.clear();
  for (const double sign : {-1.0, 1.0}) {
    pose.frame = sign;
    pose.world_from_camera = Eigen::Quaterniond(Eigen::AngleAxisd(-sign * 0.1, axis));
    camera_turns.camera.poses.push_back(pose);
  }
  const double bound = 2 * 32 * unit_roundoff * 3 * 6.5;
  expect_same_kernels(build_kernels(object_turns), build_kernels(camera_turns), bound, 2 * bound);
}

void translate(Scene& scene, const Vector3d& by) {
  for (Vector3d& p : pose_of(scene).position) p += by;
  for (CameraKey& key : scene.camera.poses) key.eye += by;
}

/// Survey coordinates that are representable lose nothing at all.
TEST(Invariance, APlace5000KilometresAwayGivesTheSameBits) {
  Scene near = discs(true), far = near;
  translate(far, {5e6, -4e6, 3e6});
  const auto a = by_name(build_kernels(near)), b = by_name(build_kernels(far));
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, kernel] : a) {
    const MovingKernel& other = b.at(name);
    EXPECT_EQ(kernel.center, other.center);
    EXPECT_EQ(kernel.axis_u, other.axis_u);
    EXPECT_EQ(kernel.axis_v, other.axis_v);
    EXPECT_EQ(kernel.weight, other.weight);
  }
  const auto image = render_abuffer(near), translated = render_abuffer(far);
  ASSERT_TRUE(image && translated);
  EXPECT_EQ(image->image.rgba, translated->image.rgba);
}

/// Others lose what rounding does to 5·10⁶ m: half of 2⁻³⁰ m, and as much again for where they move to.
TEST(Invariance, APlace5000KilometresAwayCostsItsOwnRounding) {
  Scene near = discs(false);
  set_velocities(near, 1.0);
  Scene far = near;
  translate(far, {5e6, -4e6, 3e6});
  const double bound = 2 * 0x1p-31;
  expect_same_kernels(build_kernels(near), build_kernels(far), 1.01 * bound, 2.02 * bound);
}

TEST(Invariance, ScalingAllByAPowerOfTwoScalesNothingButDepth) {
  Scene scene = discs(false);
  set_velocities(scene, 1.0);
  const auto image = render_abuffer(scene);
  ASSERT_TRUE(image);
  for (const double factor : {0x1p-12, 0x1p20}) {
    Scene scaled = scene;
    for (std::size_t i = 0; i < pose_of(scaled).size(); ++i) {
      pose_of(scaled).position[i] *= factor;
      pose_of(scaled).axis_u[i] *= static_cast<float>(factor);
      pose_of(scaled).axis_v[i] *= static_cast<float>(factor);
      scaled.objects[0].cloud.velocity[i] *= static_cast<float>(factor);
    }
    scaled.camera.poses[0].eye *= factor;
    scaled.camera.near *= factor;
    const auto result = render_abuffer(scaled);
    ASSERT_TRUE(result);
    EXPECT_EQ(image->image.rgba, result->image.rgba) << factor;
    for (std::size_t i = 0; i < image->image.depth.size(); ++i)
      ASSERT_EQ(image->image.depth[i] * static_cast<float>(factor), result->image.depth[i]) << factor;
  }
}

/// Mirrored motion gives kernels that are where they were, going back: to the rounding of their ends.
TEST(Invariance, ReversedTimeReversesEveryKernel) {
  Scene forward = discs(false), backward = forward;
  set_velocities(forward, 1.0);
  set_velocities(backward, -1.0);
  KernelSet reversed = build_kernels(backward);
  for (MovingKernel& kernel : reversed.kernels) kernel.velocity = -kernel.velocity;
  const double bound = 2 * 4 * unit_roundoff * 8.0;
  expect_same_kernels(build_kernels(forward), reversed, bound, 2 * bound);
}

/// A circular disc that turns within its plane about its centre, in eight segments, is a still disc. Its
/// turned axes are floats anew: Δu = 3·2⁻²⁴, so ρ is off by 2δ Δu = 18·2⁻²⁴, and adding eight segments'
/// floats by as much; ρ over an edge weight of ½ doubles it.
TEST(Invariance, ADiscTurningInItsPlaneStandsStill) {
  Scene still = discs(false);
  SurfelPose& pose = pose_of(still);
  pose.position.assign(1, Vector3d(0.0, 0.0, 0.0));
  const Vector3d normal = Vector3d(0.4, 0.3, -1.0).normalized(), side = normal.unitOrthogonal();
  pose.axis_u.assign(1, (1.3 * side).cast<float>());
  pose.axis_v.assign(1, (1.3 * normal.cross(side)).cast<float>());
  still.objects[0].cloud.color.resize(1);
  Scene turning = still;
  turning.objects[0].segments = 8;
  TransformKey first, last;
  first.frame = -1.0;
  last.frame = 1.0;
  first.rotate_axis = last.rotate_axis = normal;
  last.rotate_radians = 2.5;
  turning.objects[0].transform.keys = {first, last};
  ASSERT_EQ(build_kernels(turning).kernels.size(), 8u);
  const auto a = render_abuffer(still), b = render_abuffer(turning);
  ASSERT_TRUE(a && b);
  float worst = 0.0f, brightest = 0.0f;
  for (std::size_t i = 0; i < a->image.rgba.size(); ++i) {
    worst = std::max(worst, std::abs(a->image.rgba[i] - b->image.rgba[i]));
    brightest = std::max(brightest, a->image.rgba[i]);
  }
  EXPECT_EQ(brightest, 1.0f);
  EXPECT_LE(worst, 2 * (18 + 18) * 0x1p-24f);
}

}  // namespace
}  // namespace swept
