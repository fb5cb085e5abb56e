// Scenes made of bytes, for the fuzzers that render: a few discs, edge-on, huge, tiny, coincident, behind the
// eye, fast, on a few pixels; and what every picture of a valid scene keeps to.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "splat/image.h"
#include "splat/scene.h"
#include "tests/fuzz/check.h"

namespace swept::fuzz {

inline Eigen::Vector3d vector(Bytes& bytes) {
  const double x = bytes.real(), y = bytes.real();
  return {x, y, bytes.real()};
}

inline Eigen::Vector3f float_vector(Bytes& bytes) {
  const float x = bytes.real_float(), y = bytes.real_float();
  return {x, y, bytes.real_float()};
}

inline ImageModel any_model(Bytes& bytes) {
  ImageModel model;
  if (bytes.flag()) return model;
  model.delta = std::max(50.0 * bytes.unit(), 1e-3);
  model.filter_radius_px = bytes.flag() ? bytes.unit() : 100.0 * bytes.unit();
  model.coverage = bytes.flag() ? Coverage::hard : Coverage::soft;
  model.edge_weight = std::max(bytes.unit(), 0x1p-15);
  model.depth_tolerance = bytes.flag() ? bytes.unit() : 100.0 * bytes.unit();
  model.segments = bytes.below(5);
  return model;
}

inline CameraTrack any_camera(Bytes& bytes) {
  CameraTrack camera;
  camera.near = bytes.flag() ? 0x1p-10 : std::max(std::abs(bytes.real()), 1e-300);
  const int kind = bytes.below(3);
  for (int i = 0; i < (kind == 2 ? 2 : 1); ++i) {
    if (kind == 0) {
      CameraKey key;
      key.eye = {0.0, 0.0, -4.0};
      camera.poses.push_back(key);
      continue;
    }
    LookAtKey key;
    key.frame = i;
    key.eye = vector(bytes);
    key.target = vector(bytes);
    key.tan_half_fov_y = std::max(4.0 * bytes.unit(), 0x1p-13);
    camera.look_ats.push_back(key);
  }
  camera.orthographic = bytes.below(4) == 3;
  return camera;
}

inline TransformTrack any_transform(Bytes& bytes) {
  TransformTrack track;
  for (int i = 0; i < bytes.below(3); ++i) {
    TransformKey key;
    key.frame = i;
    key.translate = vector(bytes);
    key.rotate_axis = Eigen::Vector3d::Unit(bytes.below(3));
    key.rotate_radians = bytes.real();
    if (bytes.flag()) key.scale = vector(bytes);
    track.keys.push_back(key);
  }
  return track;
}

inline Object any_object(Bytes& bytes) {
  Object object;
  object.two_sided = bytes.flag();
  object.transform = any_transform(bytes);
  const int surfels = 1 + bytes.below(6), keys = bytes.below(4) == 0 ? 2 : 1;
  const bool moves = keys == 1 && bytes.flag(), colored = bytes.flag(), transparent = bytes.flag();
  for (int k = 0; k < keys; ++k) {
    SurfelPose pose;
    for (int i = 0; i < surfels; ++i) {
      // Now and then exactly where, and what, the one before it is.
      const bool same = i > 0 && bytes.below(4) == 0;
      pose.position.push_back(same ? pose.position.back() : vector(bytes));
      pose.axis_u.push_back(same ? pose.axis_u.back() : float_vector(bytes));
      pose.axis_v.push_back(same ? pose.axis_v.back() : float_vector(bytes));
    }
    object.cloud.keys.push_back({static_cast<double>(k), std::move(pose)});
  }
  for (int i = 0; i < surfels; ++i) {
    if (moves) object.cloud.velocity.push_back(float_vector(bytes));
    if (colored) object.cloud.color.push_back(float_vector(bytes));
    if (transparent) object.cloud.opacity.push_back(static_cast<float>(bytes.unit()));
  }
  return object;
}

inline Scene any_scene(Bytes& bytes) {
  Scene scene;
  scene.film = {1 + bytes.below(5), 1 + bytes.below(4), 0, 0, 0, 0};
  scene.model = any_model(bytes);
  scene.camera = any_camera(bytes);
  if (bytes.flag()) scene.shutter = {0.0, bytes.flag() ? 0.0 : bytes.unit()};
  if (bytes.flag()) scene.background = {0.25f, 0.5f, 0.75f, 1.0f};
  for (int i = 0; i < 1 + bytes.below(2); ++i) scene.objects.push_back(any_object(bytes));
  return scene;
}

/// The last point first, and so on, the objects too.
inline Scene reversed(Scene scene) {
  const auto reverse = [](auto& array) { std::reverse(array.begin(), array.end()); };
  reverse(scene.objects);
  for (Object& object : scene.objects) {
    for (SurfelKey& key : object.cloud.keys) {
      reverse(key.pose.position);
      reverse(key.pose.axis_u);
      reverse(key.pose.axis_v);
    }
    reverse(object.cloud.velocity);
    reverse(object.cloud.color);
    reverse(object.cloud.opacity);
  }
  return scene;
}

inline void check_pixels(const Image& image) {
  SWEPT_HOLDS(image.validate());
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) SWEPT_HOLDS(std::isfinite(image.rgba[4 * i + c]));
    // Sums of a few hundred floats: 12 surfels of up to 64 segments.
    SWEPT_HOLDS(image.rgba[4 * i + 3] >= 0.0f && image.rgba[4 * i + 3] <= 1.0f + 1000 * 0x1p-24f);
    SWEPT_HOLDS(image.depth[i] >= 0.0f);
  }
}

inline void check_same(const Image& a, const Image& b) {
  SWEPT_HOLDS(a.rgba == b.rgba);
  SWEPT_HOLDS(a.depth == b.depth);
}

}  // namespace swept::fuzz
