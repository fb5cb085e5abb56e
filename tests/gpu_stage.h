// Kernels and scenes made for the tests of the GPU passes.
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "gpu_passes/six_pass/pass_runner.h"
#include "splat/kernel/kernel_set.h"
#include "splat/scene.h"

namespace swept {

/// Looks along z: 100 px focal length, the axis through the middle of a film of 32 × 32 px. A px at depth 100
/// is one unit.
inline KernelSet stage_kernels() {
  KernelSet set;
  set.projection = {100.0, 16.0, 16.0};
  set.near = 1.0;
  return set;
}

inline Scene stage_scene() {
  Scene scene;
  scene.film = {32, 32, 0, 0, 0, 0};
  scene.camera.look_ats.emplace_back();
  scene.camera.near = 1.0;
  scene.model.coverage = Coverage::hard;
  return scene;
}

/// One sub-frame of kernels over all of the scene's film.
inline FrameSetup stage_setup(const KernelSet& set, const Scene& scene, std::span<const Pass> passes) {
  FrameSetup setup{scene.film.width, scene.film.height, passes, false, {}};
  for (int c = 0; c < 4; ++c) setup.block.background[c] = scene.background[c];
  setup.block.window_size = {static_cast<float>(setup.width), static_cast<float>(setup.height)};
  setup.block.near_plane = static_cast<float>(set.near);
  setup.block.delta = static_cast<float>(scene.model.delta);
  setup.block.edge_weight =
      scene.model.coverage == Coverage::hard ? 0.0f : static_cast<float>(scene.model.edge_weight);
  setup.block.share = 1.0f;
  return setup;
}

/// A disc facing the camera. `x`, `y` in px of the film at mid-shutter; `motion_px` to the right over the
/// shutter.
inline MovingKernel disc(double x, double y, double depth, double radius_px, double motion_px,
                         const Eigen::Vector3f& color) {
  const double per_px = depth / 100.0;
  MovingKernel kernel;
  kernel.center = {(x - 16.0) * per_px, (y - 16.0) * per_px, depth};
  kernel.velocity = {motion_px * per_px, 0.0, 0.0};
  kernel.axis_u = {static_cast<float>(radius_px * per_px), 0.0f, 0.0f};
  kernel.axis_v = {0.0f, static_cast<float>(radius_px * per_px), 0.0f};
  kernel.facing.setZero();
  kernel.depth_tolerance = 0.5f;
  kernel.color = {color[0], color[1], color[2], 1.0f};
  return kernel;
}

/// A sphere of discs with stripes of colour. Object space.
inline Object striped_sphere(double radius, int points) {
  Object object;
  object.name = "sphere";
  object.cloud.keys.resize(1);
  SurfelPose& pose = object.cloud.keys.front().pose;
  const double disc_radius = 1.6 * radius * std::sqrt(4.0 / points);
  for (int i = 0; i < points; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / points, angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double ring = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d n(ring * std::cos(angle), ring * std::sin(angle), z);
    const Eigen::Vector3d u = n.unitOrthogonal();
    pose.position.push_back(radius * n);
    pose.axis_u.push_back((disc_radius * u).cast<float>());
    pose.axis_v.push_back((disc_radius * n.cross(u)).cast<float>());
    const float stripe = std::sin(9.0 * n.x()) > 0.0 ? 0.9f : 0.15f;
    object.cloud.color.emplace_back(stripe, 0.4f, 1.0f - stripe);
  }
  return object;
}

}  // namespace swept
