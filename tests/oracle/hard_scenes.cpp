#include "tests/oracle/hard_scenes.h"

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include <Eigen/Geometry>

namespace swept::oracle {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double focal_px = 36.0;

const Vector3f red{0.9f, 0.15f, 0.1f}, green{0.15f, 0.7f, 0.2f}, blue{0.1f, 0.25f, 0.9f},
    white{0.95f, 0.95f, 0.9f}, black{0.05f, 0.05f, 0.06f};

Scene stage() {
  Scene scene;
  scene.film = {48, 36, 0, 0, 0, 0};
  scene.shutter = {-0.5, 0.5};
  scene.camera.poses.emplace_back();
  scene.camera.near = 0.1;
  scene.background = {0.25f, 0.28f, 0.32f, 1.0f};
  return scene;
}

struct Disc {
  Vector3d center, axis_u, axis_v, velocity;
  Vector3f color;
};

void add(Scene& scene, const std::vector<Disc>& discs) {
  Object object;
  SurfelPose pose;
  for (const Disc& disc : discs) {
    pose.position.push_back(disc.center);
    pose.axis_u.push_back(disc.axis_u.cast<float>());
    pose.axis_v.push_back(disc.axis_v.cast<float>());
    object.cloud.velocity.push_back(disc.velocity.cast<float>());
    object.cloud.color.push_back(disc.color);
  }
  object.cloud.keys.push_back({0.0, std::move(pose)});
  scene.objects.push_back(std::move(object));
}

/// A parallelogram of n × n discs, chequered.
std::vector<Disc> surface(const Vector3d& center, const Vector3d& half_u, const Vector3d& half_v,
                          const Vector3d& velocity, const Vector3f& one, const Vector3f& other, int n = 16) {
  std::vector<Disc> discs;
  const double reach = 1.6 / n;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      discs.push_back({center + ((2 * i + 1.0) / n - 1.0) * half_u + ((2 * j + 1.0) / n - 1.0) * half_v,
                       reach * half_u, reach * half_v, velocity, (i / 4 + j / 4) % 2 ? one : other});
  return discs;
}

Disc round_disc(const Vector3d& center, const Vector3d& normal, double radius, const Vector3d& velocity,
                const Vector3f& color) {
  const Vector3d side = normal.unitOrthogonal();
  return {center, radius * side, radius * normal.cross(side), velocity, color};
}

/// Behind the rest, for what is in front to show against.
void add_wall(Scene& scene) {
  add(scene, surface({0.0, 0.0, 9.0}, {7.0, 0.0, 0.0}, {0.0, 5.5, 0.0}, Vector3d::Zero(), white, black));
}

Scene no_motion() {
  Scene scene = stage();
  add_wall(scene);
  add(scene, surface({0.1, 0.0, 4.0}, {1.2, 0.3, 0.5}, {-0.2, 0.9, 0.4}, Vector3d::Zero(), red, white));
  return scene;
}

Scene in_plane() {
  Scene scene = stage();
  add_wall(scene);
  const Vector3d u(0.8, 0.1, 0.7), v(-0.1, 0.7, 0.2);
  add(scene, surface({-0.6, 0.3, 4.0}, u, v, 0.8 * u - 0.3 * v, red, white));
  add(scene, {{Vector3d(0.9, -0.8, 3.5), 0.5 * u, 0.5 * v, -0.6 * u + 0.4 * v, blue}});
  return scene;
}

Scene along_ray() {
  Scene scene = stage();
  add_wall(scene);
  std::vector<Disc> discs;
  for (int i = -2; i <= 2; ++i)
    for (int j = -1; j <= 1; ++j) {
      const Vector3d ray(0.22 * i, 0.3 * j, 1.0);
      discs.push_back(round_disc(4.0 * ray, Vector3d(0.3 * j, 0.2 * i, -1.0).normalized(), 0.35,
                                 (i % 2 ? -3.0 : 3.5) * ray, i % 2 ? red : green));
    }
  add(scene, discs);
  return scene;
}

/// Tilted from their own line of sight by nothing, and by 10⁻¹² to 10⁻¹.
Scene edge_on() {
  Scene scene = stage();
  add_wall(scene);
  std::vector<Disc> discs;
  for (int i = 0; i < 13; ++i) {
    const Vector3d center = 3.0 * Vector3d(-0.6 + 0.1 * i, 0.02 * (i % 3), 1.0);
    const Vector3d sight = center.normalized(), side = sight.cross(Vector3d::UnitY()).normalized();
    const double tilt = i == 0 ? 0.0 : std::pow(10.0, i - 13.0);
    discs.push_back(
        round_disc(center, (side + tilt * sight).normalized(), 0.8, {0.15, 0.3, 0.1}, i % 2 ? red : green));
  }
  add(scene, discs);
  return scene;
}

Scene turning_through_edge_on() {
  Scene scene = stage();
  add_wall(scene);
  add(scene, surface(Vector3d::Zero(), {1.1, 0.0, 0.0}, {0.0, 1.0, 0.0}, Vector3d::Zero(), red, white));
  TransformKey first, last;
  first.frame = -0.5;
  last.frame = 0.5;
  first.translate = last.translate = {0.2, 0.1, 4.0};
  first.rotate_radians = 1.2;
  last.rotate_radians = 2.0;
  scene.objects.back().transform.keys = {first, last};
  scene.objects.back().segments = 8;
  return scene;
}

Scene through_near_plane() {
  Scene scene = stage();
  add_wall(scene);
  add(scene, surface({0.0, 0.02, 0.15}, {0.12, 0.0, 0.02}, {0.0, 0.09, 0.01}, {0.01, 0.0, -0.3}, red, white));
  return scene;
}

Scene through_eye() {
  Scene scene = stage();
  add_wall(scene);
  add(scene,
      {round_disc({0.0, 0.0, 0.0}, Vector3d(0.3, 0.2, -1.0).normalized(), 0.3, {0.4, 0.2, -3.0}, red),
       round_disc({0.0, 0.0, 0.0}, Vector3d(1.0, 0.1, 0.2).normalized(), 0.2, {-0.5, 0.1, 2.0}, green)});
  return scene;
}

Scene minute_motion() {
  Scene scene = no_motion();
  for (Vector3f& v : scene.objects[1].cloud.velocity) v = Vector3f(1e-6f, 0.7e-6f, 0.0f) * (4.0f / 36.0f);
  return scene;
}

/// 10⁵ px: a wall 40,000 px wide passes, and a hundred small discs.
Scene vast_motion() {
  Scene scene = stage();
  add_wall(scene);
  const double px = 4.0 / focal_px;
  add(scene,
      {round_disc({100.0 * px, 0.0, 4.0}, -Vector3d::UnitZ(), 2e4 * px, {1e5 * px, 100.0 * px, 0.0}, red)});
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Disc> discs;
  for (int i = 0; i < 100; ++i)
    discs.push_back(round_disc({2e4 * px * unit(random), 18.0 * px * unit(random), 3.5},
                               Vector3d(0.3 * unit(random), 0.3 * unit(random), -1.0).normalized(), 4.0 * px,
                               {1e5 * px, 0.0, 0.0}, green));
  add(scene, discs);
  return scene;
}

/// Discs of no area show nothing, beside one that does.
Scene zero_axis() {
  Scene scene = in_plane();
  add(scene, {{Vector3d(-0.5, -0.5, 2.0), {0.6, 0.0, 0.0}, Vector3d::Zero(), {0.3, 0.0, 0.0}, green},
              {Vector3d(0.5, -0.5, 2.0), Vector3d::Zero(), Vector3d::Zero(), {0.3, 0.0, 0.0}, green}});
  return scene;
}

Scene parallel_axes() {
  Scene scene = in_plane();
  add(scene, {{Vector3d(-0.5, -0.5, 2.0), {0.6, 0.1, 0.0}, {1.2, 0.2, 0.0}, {0.3, 0.0, 0.0}, green},
              {Vector3d(0.4, 0.4, 2.0), {0.3, 0.2, 0.1}, {-0.3, -0.2, -0.1}, {0.0, 0.3, 0.0}, green}});
  return scene;
}

Scene enormous_axes() {
  Scene scene = stage();
  add(scene,
      {round_disc({1e3, 2e3, 6e3}, Vector3d(0.2, 0.1, -1.0).normalized(), 1e9, {0.0, 0.0, 1e3}, blue),
       round_disc({0.0, 1e5, 2e5}, Vector3d(0.0, -1.0, -0.05).normalized(), 1e20, {1e4, -3e4, 0.0}, white)});
  add(scene, surface({0.0, 0.0, 4.0}, {0.9, 0.2, 0.5}, {-0.2, 0.8, 0.4}, {0.7, 0.3, 0.0}, red, white));
  return scene;
}

Scene survey() {
  Scene scene = in_plane();
  const Vector3d place(5e6, -4e6, 3e6);
  for (Object& object : scene.objects)
    for (Vector3d& p : object.cloud.keys[0].pose.position) p += place;
  scene.camera.poses[0].eye = place;
  return scene;
}

/// Unfiltered, and covered or not: the rims' lines run through pixel centres 5 px above and below the
/// centre's.
Scene tangent() {
  Scene scene = stage();
  scene.model.filter_radius_px = 0.0;
  scene.model.coverage = Coverage::hard;
  const double px = 3.6 / focal_px;
  add(scene,
      {{Vector3d(0.0, 0.5 * px, 3.6), {5.0 * px, 0.0, 0.0}, {0.0, 5.0 * px, 0.0}, {20.0 * px, 0.0, 0.0}, red},
       {Vector3d(0.5 * px, 0.0, 3.7),
        {4.0 * 3.7 / 3.6 * px, 0.0, 0.0},
        {0.0, 4.0 * px, 0.0},
        {0.0, 16.0 * px, 0.0},
        green}});
  return scene;
}

Scene coincident() {
  Scene scene = stage();
  add_wall(scene);
  const Vector3d center(0.0, 0.0, 4.0), u(1.0, 0.2, 0.4), v(-0.2, 0.8, 0.3), velocity(0.9, 0.3, 0.5);
  add(scene, surface(center, u, v, velocity, red, red));
  add(scene, surface(center, u, v, velocity, blue, white));
  return scene;
}

Scene crossing() {
  Scene scene = stage();
  add_wall(scene);
  add(scene, surface({-0.1, 0.0, 4.0}, {1.2, 0.1, 0.1}, {0.0, 0.9, 0.1}, {0.3, 0.0, 1.5}, red, white));
  add(scene, surface({0.1, 0.0, 4.1}, {1.0, 0.0, -0.1}, {0.1, 1.1, 0.0}, {-0.3, 0.2, -1.7}, blue, green));
  return scene;
}

Scene interpenetrating() {
  Scene scene = stage();
  add_wall(scene);
  add(scene, surface({0.0, 0.0, 4.0}, {1.0, 0.0, 0.8}, {0.0, 1.0, 0.0}, {0.5, 0.1, 0.0}, red, white));
  add(scene, surface({0.0, 0.0, 4.0}, {1.0, 0.0, -0.8}, {0.1, 1.0, 0.0}, {-0.4, 0.0, 0.2}, blue, green));
  return scene;
}

Scene sub_pixel() {
  Scene scene = stage();
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Disc> discs;
  for (int i = 0; i < 3000; ++i) {
    const double radius = std::pow(10.0, -2.0 + 1.5 * std::abs(unit(random))) * 4.0 / focal_px;
    discs.push_back(round_disc({2.0 * unit(random), 1.4 * unit(random), 4.0 + unit(random)},
                               Vector3d(unit(random), unit(random), unit(random)).normalized(), radius,
                               0.3 * Vector3d(unit(random), unit(random), unit(random)),
                               i % 3 ? white : red));
  }
  add(scene, discs);
  return scene;
}

Scene screen_filling() {
  Scene scene = stage();
  add(scene,
      {round_disc({0.5, 0.2, 5.0}, Vector3d(0.2, 0.1, -1.0).normalized(), 12.0, {6.0, 2.0, 1.0}, blue),
       round_disc({-2.0, 0.5, 3.0}, Vector3d(-0.4, 0.1, -1.0).normalized(), 3.0, {1.5, 0.0, 0.5}, red)});
  return scene;
}

/// A surface that leaves as the shutter opens and one that arrives as it closes, over a still wall.
Scene both_ends() {
  Scene scene = stage();
  add_wall(scene);
  const Vector3d across(24.0, 0.0, 0.0);
  add(scene,
      surface(Vector3d(0.0, 0.4, 4.0) + 0.5 * across, {0.9, 0.0, 0.0}, {0.0, 0.7, 0.0}, across, red, white));
  add(scene, surface(Vector3d(0.0, -0.4, 4.5) + 0.5 * across, {0.9, 0.0, 0.0}, {0.0, 0.7, 0.0}, -across, blue,
                     green));
  return scene;
}

Scene closed_shutter() {
  Scene scene = crossing();
  scene.shutter = {0.1, 0.1};
  return scene;
}

/// On 2 × 2 px.
Scene ten_thousand_fragments() {
  Scene scene = stage();
  scene.film = {2, 2, 0, 0, 0, 0};
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Disc> discs;
  const double px = 4.0 / 2.0;  // at depth 4, focal length 2 px
  for (int i = 0; i < 10500; ++i) {
    const double z = 4.0 + unit(random);
    const double angle = std::numbers::pi * unit(random);
    discs.push_back({Vector3d(0.05 * px * unit(random), 0.05 * px * unit(random), z),
                     {1.2 * px * std::cos(angle), 1.2 * px * std::sin(angle), 0.0},
                     {-1.2 * px * std::sin(angle), 1.2 * px * std::cos(angle), 0.0},
                     Vector3d(unit(random), unit(random), unit(random)),
                     i % 3 ? (i % 3 == 1 ? red : green) : blue});
  }
  add(scene, discs);
  return scene;
}

}  // namespace

const std::vector<HardScene>& hard_scenes() {
  static const std::vector<HardScene> scenes = {
      {"no_motion", "a still chequered surface before a still wall", 90, 2, no_motion},
      {"motion_in_plane", "a surface and a disc that slide within their own planes", 90, 1024, in_plane},
      {"motion_along_ray", "discs that move along the rays through their centres, near and away", 90, 2048,
       along_ray},
      {"edge_on", "discs seen edge-on, and tilted from that by 1e-12 to 0.1, as they rise", 80, 1024,
       edge_on},
      {"turning_through_edge_on", "a surface that turns through edge-on, in eight segments", 80, 1024,
       turning_through_edge_on},
      {"through_near_plane", "a surface that passes the near plane and is cut there", 90, 16384,
       through_near_plane},
      {"through_eye", "two discs whose centres pass the eye", 80, 16384, through_eye},
      {"motion_1e-6_px", "a surface that moves by a millionth of a pixel", 90, 256, minute_motion},
      {"motion_1e5_px", "discs that move by 100,000 px, one of them 40,000 px wide", 85, 32768, vast_motion},
      {"axis_of_length_zero", "discs without an area, which show nothing, before a surface", 90, 1024,
       zero_axis},
      {"parallel_axes", "discs with parallel axes, which show nothing, before a surface", 90, 1024,
       parallel_axes},
      {"enormous_axes", "discs of radius 1e9 and 1e20 behind a surface", 90, 1024, enormous_axes, 5e-3},
      {"far_from_origin", "motion_in_plane, 5,000 km from the origin", 90, 1024, survey},
      {"tangent", "discs whose rims run through pixel centres, hard edges", 80, 4096, tangent},
      {"coincident", "two surfaces in one place, red and chequered", 90, 1024, coincident},
      {"crossing", "two surfaces that pass through each other in depth", 90, 4096, crossing},
      {"interpenetrating", "two surfaces that intersect throughout the exposure", 90, 2048, interpenetrating},
      {"sub_pixel", "3,000 discs of 0.01 to 0.3 px", 90, 1024, sub_pixel},
      {"screen_filling", "two discs larger than the film", 90, 8192, screen_filling},
      {"both_ends", "surfaces seen only as the shutter opens and as it closes", 90, 4096, both_ends},
      {"closed_shutter", "crossing, with a shutter that is open for no time", 90, 2, closed_shutter},
      {"ten_thousand_fragments", "10,500 moving discs that all cover the same four pixels at some time", 90,
       2048, ten_thousand_fragments},
  };
  return scenes;
}

}  // namespace swept::oracle
