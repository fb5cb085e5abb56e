// A small stage, and what is put on it: scenes for tests of whole renderers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Geometry>

#include "splat/scene.h"

namespace swept::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Eigen::Vector3d vector(double low, double high) {
    const double x = (*this)(low, high), y = (*this)(low, high);
    return {x, y, (*this)(low, high)};
  }

 private:
  std::mt19937_64 engine_;
};

/// 64 × 48 px; the shutter is open from frame 0 to 1. The eye looks along −z of the world from z = 5.
inline Scene stage() {
  Scene scene;
  scene.film = {64, 48, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back();
  return scene;
}

inline void add_disc(Object& object, const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                     double radius, const Eigen::Vector3f& color = Eigen::Vector3f::Ones()) {
  if (object.cloud.keys.empty()) object.cloud.keys.resize(1);
  const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  SurfelPose& pose = object.cloud.keys.front().pose;
  pose.position.push_back(position);
  pose.axis_u.push_back((radius * u).cast<float>());
  pose.axis_v.push_back((radius * v).cast<float>());
  object.cloud.color.push_back(color);
}

/// Triangles at random: corners within ±0.6 of a middle, and of any colour. `middle()` gives these.
template <class Middle>
Object triangles_about(int triangles, float opacity, Random& random, const Middle& middle) {
  Object object;
  for (int t = 0; t < triangles; ++t) {
    const Eigen::Vector3d at = middle();
    for (int i = 0; i < 3; ++i) {
      // One after the other: in which order a call's arguments are worked out is the compiler's own affair.
      const Eigen::Vector3d color = random.vector(0.0, 1.0), corner = at + random.vector(-0.6, 0.6);
      add_disc(object, corner, {0, 0, 1}, 0.1, color.cast<float>());
      object.cloud.opacity.push_back(opacity);
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    object.triangles.push_back({first, first + 1, first + 2});
  }
  return object;
}

/// The same points in the other order, of a cloud with one pose.
inline void reverse_points(SurfelCloud& cloud) {
  const auto reverse = [](auto&... of) { (std::reverse(of.begin(), of.end()), ...); };
  SurfelPose& pose = cloud.keys[0].pose;
  reverse(pose.position, pose.axis_u, pose.axis_v, cloud.velocity, cloud.color, cloud.opacity,
          cloud.oriented);
}

inline Object checkered_sphere(double radius, int points) {
  Object object;
  for (int i = 0; i < points; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / points, angle = i * 2.399963229728653;
    const Eigen::Vector3d n(std::sqrt(1.0 - z * z) * std::cos(angle),
                            std::sqrt(1.0 - z * z) * std::sin(angle), z);
    const bool odd = (static_cast<int>((n.x() + 1.0) * 4.0) + static_cast<int>((n.y() + 1.0) * 4.0)) % 2 != 0;
    add_disc(object, radius * n, n, radius * std::sqrt(4.0 * M_PI / points),
             odd ? Eigen::Vector3f(0.9f, 0.2f, 0.1f) : Eigen::Vector3f(0.1f, 0.3f, 0.9f));
  }
  return object;
}

/// The rim of a wheel, 1.5 in radius, of small discs that are of either colour by turns; in an exposure of
/// one frame it turns by 90° about the view axis.
inline Object wheel(int discs, double radius, const Eigen::Vector3f& color = Eigen::Vector3f::Ones(),
                    const Eigen::Vector3f& other = Eigen::Vector3f::Ones()) {
  Object object;
  for (int i = 0; i < discs; ++i) {
    const double angle = 2.0 * M_PI * i / discs;
    add_disc(object, {1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.0}, Eigen::Vector3d::UnitZ(), radius,
             i % 2 == 0 ? color : other);
  }
  object.transform.keys.resize(2);
  object.transform.keys[1].frame = 1.0;
  for (TransformKey& key : object.transform.keys) key.rotate_axis = Eigen::Vector3d::UnitZ();
  object.transform.keys[1].rotate_radians = 0.5 * M_PI;
  return object;
}

inline void move(Object& object, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                 double radians = 0.0) {
  TransformKey open, close;
  close.frame = 1.0;
  open.translate = from;
  close.translate = to;
  open.rotate_axis = close.rotate_axis = Eigen::Vector3d(0.6, 0.8, 0.0);
  close.rotate_radians = radians;
  object.transform.keys = {open, close};
}

/// Two spheres that pass through each other while one turns, in front of a still one.
inline Scene busy_scene() {
  Scene scene = stage();
  scene.model.segments = 3;
  scene.objects = {checkered_sphere(0.8, 900), checkered_sphere(0.7, 700), checkered_sphere(0.5, 400)};
  move(scene.objects[0], {-0.8, -0.2, 0.6}, {0.5, 0.1, -0.6}, 0.8);
  move(scene.objects[1], {0.9, 0.3, -0.5}, {-0.1, -0.2, 0.5});
  move(scene.objects[2], {0.2, 0.8, -2.0}, {0.2, 0.8, -2.0});
  return scene;
}

}  // namespace swept::test
