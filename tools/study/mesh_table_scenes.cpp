// The scenes of the tables about triangles.
#include <algorithm>
#include <cmath>

#include "tools/study/mesh_tables.h"

namespace swept {
namespace {

/// Nine twisted blades that turn by a quarter before a wall.
Scene fan(int side_px) {
  Scene scene = square_stage(side_px);
  Object& blades = scene.objects.emplace_back();
  constexpr int count = 9, steps = 12;
  for (int b = 0; b < count; ++b) {
    const double around = 2.0 * M_PI * b / count;
    const float shade = 0.25f + 0.75f * static_cast<float>(b) / count;
    std::uint32_t before[2] = {0, 0};
    for (int s = 0; s <= steps; ++s) {
      const double r = 0.2 + 1.4 * s / steps, half = 0.12 + 0.15 * s / steps, twist = 0.9 - 0.6 * s / steps;
      const Eigen::Vector3f color(shade, 0.3f, 1.0f - shade * static_cast<float>(s) / steps);
      std::uint32_t at[2];
      for (int side = 0; side < 2; ++side) {
        const double across = side == 0 ? -half : half;
        const double x = r, y = across * std::cos(twist), z = across * std::sin(twist);
        at[side] = add_point(
            blades,
            {x * std::cos(around) - y * std::sin(around), x * std::sin(around) + y * std::cos(around), z},
            color);
      }
      if (s > 0) {
        blades.triangles.push_back({before[0], at[0], at[1]});
        blades.triangles.push_back({before[0], at[1], before[1]});
      }
      std::copy(at, at + 2, before);
    }
  }
  blades.two_sided = true;
  turn(blades, 90.0, {0.2, 0.1, 1.0});
  Object& wall = scene.objects.emplace_back();
  for (const auto& [x, y] : {std::pair{-3.0, -3.0}, {3.0, -3.0}, {3.0, 3.0}, {-3.0, 3.0}})
    add_point(wall, {x, y, -1.0}, {0.8f, 0.8f, 0.7f});
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  wall.two_sided = true;
  return scene;
}

template <class Array>
void pick(Array& values, const std::vector<std::uint32_t>& from) {
  if (values.empty()) return;
  Array picked;
  picked.reserve(from.size());
  for (const std::uint32_t i : from) picked.push_back(values[i]);
  values = std::move(picked);
}

}  // namespace

void make_flat(Object& object) {
  std::vector<std::uint32_t> from;
  for (Triangle& triangle : object.triangles)
    for (std::uint32_t& corner : triangle) {
      from.push_back(corner);
      corner = static_cast<std::uint32_t>(from.size() - 1);
    }
  SurfelCloud& cloud = object.cloud;
  for (SurfelKey& key : cloud.keys) {
    pick(key.pose.position, from);
    pick(key.pose.axis_u, from);
    pick(key.pose.axis_v, from);
  }
  pick(cloud.lifetime, from);
  pick(cloud.oriented, from);
  pick(cloud.angular_velocity, from);
  pick(cloud.velocity, from);
  pick(cloud.acceleration, from);
  cloud.looks.clear();
  pick(cloud.color, from);
  pick(cloud.opacity, from);
  for (std::size_t i = 0; i + 2 < cloud.color.size(); i += 3) {
    const Eigen::Vector3f mean = (cloud.color[i] + cloud.color[i + 1] + cloud.color[i + 2]) / 3.0f;
    cloud.color[i] = cloud.color[i + 1] = cloud.color[i + 2] = mean;
  }
}

std::vector<TraversalScene> visibility_scenes(int side_px, const std::string& folder) {
  std::vector<TraversalScene> scenes;
  for (TraversalScene& scene : traversal_scenes(side_px, folder)) {
    if (scene.title == "Rotation") scenes.push_back({"Fan", "", fan(side_px)});
    if (scene.title == "Cloth ball" || scene.title == "Horse" || scene.title == "Rotation")
      scenes.push_back(std::move(scene));
  }
  for (TraversalScene& scene : scenes)
    for (Object& object : scene.scene.objects) make_flat(object);
  return scenes;
}

}  // namespace swept
