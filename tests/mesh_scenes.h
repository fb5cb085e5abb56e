// Scenes of triangles that several tests draw.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <utility>

#include "tests/splat_scenes.h"

namespace swept::test {

/// The shutter is open from frame 0 to 1; the camera at the origin looks along z, y down.
inline Scene mesh_stage(int width, int height, double tan_half_fov_y) {
  Scene scene;
  scene.film = {width, height, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats = {looking_along_z(0.0, {0, 0, 0}, {0, 0, 1}, 60.0)};
  scene.camera.look_ats[0].tan_half_fov_y = tan_half_fov_y;
  scene.camera.near = 0.1;
  return scene;
}

/// A corner, or an upright disc. Returns its index.
inline std::uint32_t add_point(Object& object, const Eigen::Vector3d& position, const Eigen::Vector3f& color,
                               float radius = 0.1f) {
  if (object.cloud.keys.empty()) object.cloud.keys.emplace_back();
  SurfelPose& pose = object.cloud.keys[0].pose;
  pose.position.push_back(position);
  pose.axis_u.emplace_back(radius, 0.0f, 0.0f);
  pose.axis_v.emplace_back(0.0f, radius, 0.0f);
  object.cloud.color.push_back(color);
  return static_cast<std::uint32_t>(pose.size() - 1);
}

inline void move_points(Object& object, const Eigen::Vector3f& velocity) {
  object.cloud.velocity.assign(object.cloud.size(), velocity);
}

/// Upright, of two triangles.
inline Object rectangle(const Eigen::Vector3d& middle, double half_width, double half_height,
                        const Eigen::Vector3f& color) {
  Object object;
  for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
    add_point(object, middle + Eigen::Vector3d(x * half_width, y * half_height, 0.0), color);
  object.triangles = {{0, 1, 2}, {0, 2, 3}};
  return object;
}

/// Triangles at random, of all sizes, some of them through the near plane and behind the eye.
inline Object triangle_soup(int triangles, unsigned seed, bool transparent, double speed = 0.5) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  // In which order a call's arguments are worked out is the compiler's own affair: each number by itself.
  const auto vector = [&](double x, double y, double z_from, double z_to) {
    const double at_z = uniform(z_from, z_to), at_y = uniform(-y, y);
    return Eigen::Vector3d(uniform(-x, x), at_y, at_z);
  };
  Object object;
  for (int t = 0; t < triangles; ++t) {
    const Eigen::Vector3d middle = vector(2.0, 1.5, -0.2, 6.0);
    const double size = std::pow(10.0, uniform(-2.0, 0.3));
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d offset = vector(size, size, -size, size);
      const auto channel = [&] { return static_cast<float>(uniform(0.0, 1.0)); };
      add_point(object, middle + offset, {channel(), channel(), channel()});
      object.cloud.velocity.push_back(vector(speed, speed, -speed, speed).cast<float>());
      if (transparent) object.cloud.opacity.push_back(channel());
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    object.triangles.push_back({first, first + 1, first + 2});
  }
  return object;
}

}  // namespace swept::test
