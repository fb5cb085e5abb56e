#include "tools/engine_scenes.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <numbers>
#include <random>
#include <string_view>
#include <utility>

#include "datasets/generators.h"

namespace swept {
Scene engine_stage() {
  Scene scene;
  scene.film = {engine_film_px, engine_film_px, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  LookAtKey& key = scene.camera.look_ats.emplace_back();
  key.eye = {0.0, 0.0, engine_distance};
  key.tan_half_fov_y = engine_tan_half_fov;
  return scene;
}

namespace {

Object object_of(const std::string& shape, std::size_t points,
                 const std::map<std::string, double>& parameters) {
  Object object;
  auto cloud = generate(shape, points, parameters);
  if (cloud) object.cloud = std::move(*cloud);
  return object;
}

/// In a straight line, by so many pixels in all, through `middle`.
void move(Object& object, const Eigen::Vector3d& middle, const Eigen::Vector3d& direction, double motion_px) {
  const Eigen::Vector3d half = direction.normalized() * (0.5 * motion_px / engine_px_per_unit);
  object.transform.keys.resize(2);
  object.transform.keys[0].translate = middle - half;
  object.transform.keys[1].frame = 1.0;
  object.transform.keys[1].translate = middle + half;
}

/// A single object that moves in a straight line through the middle.
Scene passing(Object object, const Eigen::Vector3d& direction, double motion_px) {
  Scene scene = engine_stage();
  move(object, {0, 0, 0}, direction, motion_px);
  scene.objects.push_back(std::move(object));
  return scene;
}

Scene sphere(std::size_t points, double motion_px) {
  return passing(object_of("sphere", points, {{"sectors", 24}, {"rings", 12}}), {1.0, 0.3, 0.0}, motion_px);
}

Scene knot(std::size_t points, double motion_px) {
  return passing(object_of("knot", points, {}), {1.0, 0.5, 0.2}, motion_px);
}

/// Its rim moves by so much.
Scene rotation(std::size_t points, double motion_px) {
  Scene scene = engine_stage();
  Object object = object_of("knot", points, {});
  object.transform.keys.resize(2);
  object.transform.keys[1].frame = 1.0;
  for (TransformKey& key : object.transform.keys)
    key.rotate_axis = Eigen::Vector3d(0.2, 1.0, 0.4).normalized();
  object.transform.keys[1].rotate_radians = motion_px / engine_px_per_unit;
  scene.objects.push_back(std::move(object));
  return scene;
}

Scene wall(std::size_t points, double motion_px) {
  Scene scene = engine_stage();
  Object still = object_of("plane", points / 2, {});
  still.transform.keys.resize(1);
  still.transform.keys[0].translate = {0.0, 0.0, -1.0};
  still.transform.keys[0].rotate_axis = {1.0, 0.0, 0.0};
  still.transform.keys[0].rotate_radians = 0.5 * std::numbers::pi;
  still.transform.keys[0].scale = {2.0, 2.0, 2.0};
  scene.objects.push_back(std::move(still));
  Object object = object_of("sphere", points / 2, {{"radius", 0.4}});
  move(object, {0, 0, 0.3}, {1.0, 0.1, 0.0}, motion_px);
  scene.objects.push_back(std::move(object));
  return scene;
}

Scene crossing(std::size_t points, double motion_px) {
  Scene scene = engine_stage();
  for (const double side : {-1.0, 1.0}) {
    Object object = object_of(
        side < 0.0 ? "sphere" : "knot", points / 2,
        side < 0.0 ? std::map<std::string, double>{{"radius", 0.8}} : std::map<std::string, double>{});
    move(object, {0.15 * side, 0.0, 0.0}, {-side, 0.2, side}, motion_px);
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

/// The particles have velocities of their own; the exposure is as long as the fastest needs.
Scene sparks(std::size_t points, double motion_px) {
  Scene scene = engine_stage();
  Object object = object_of("sparks", points, {});
  double fastest = 0.0;
  for (const Eigen::Vector3f& v : object.cloud.velocity) fastest = std::max(fastest, double{v.norm()});
  object.transform.keys.resize(1);
  object.transform.keys[0].translate = {0.0, -1.0, 0.0};
  scene.shutter.close = motion_px / engine_px_per_unit / fastest;
  scene.objects.push_back(std::move(object));
  return scene;
}

using Make = Scene (*)(std::size_t points, double motion_px);
struct Entry {
  const char* name;
  Make make;
  std::size_t points;
  double motion_px;
};

constexpr Entry entries[] = {
    {"sphere-100k-10", sphere, 100'000, 10},     {"sphere-100k-30", sphere, 100'000, 30},
    {"sphere-100k-100", sphere, 100'000, 100},   {"sphere-500k-10", sphere, 500'000, 10},
    {"sphere-500k-30", sphere, 500'000, 30},     {"sphere-500k-100", sphere, 500'000, 100},
    {"sphere-1M-10", sphere, 1'000'000, 10},     {"sphere-1M-30", sphere, 1'000'000, 30},
    {"sphere-1M-100", sphere, 1'000'000, 100},   {"knot-500k-30", knot, 500'000, 30},
    {"rotation-500k-30", rotation, 500'000, 30}, {"wall-400k-60", wall, 400'000, 60},
    {"crossing-300k-40", crossing, 300'000, 40}, {"sparks-20k-200", sparks, 20'000, 200},
    {"sphere-10k-30", sphere, 10'000, 30},       {"sphere-10M-30", sphere, 10'000'000, 30},
};

Scene random_scene(std::uint32_t seed) {
  std::mt19937 bits(seed);
  // Not the library's distributions, which differ from one to the next.
  const auto between = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(bits()) * 0x1p-32);
  };
  const auto spread = [&](double low, double high) {
    return std::exp(between(std::log(low), std::log(high)));
  };
  constexpr const char* shapes[] = {"sphere", "knot", "head", "page", "ribbon", "fan", "plane", "sparks"};
  Scene scene = engine_stage();
  scene.film.width = scene.film.height = static_cast<int>(spread(192.0, 512.0));
  const double unit_px = engine_px_per_unit * scene.film.height / engine_film_px;
  for (int left = 1 + static_cast<int>(bits() % 3); left > 0; --left) {
    Object object =
        object_of(shapes[bits() % std::size(shapes)], static_cast<std::size_t>(spread(3e3, 1e5)), {});
    object.transform.keys.resize(2);
    TransformKey &from = object.transform.keys[0], &to = object.transform.keys[1];
    to.frame = 1.0;
    from.scale = to.scale = Eigen::Vector3d::Constant(spread(0.3, 1.2));
    from.translate = {between(-0.8, 0.8), between(-0.8, 0.8), between(-0.8, 0.8)};
    const double way = between(0.0, 1.0) < 0.2 ? 0.0 : spread(2.0, 150.0) / unit_px;
    const Eigen::Vector3d direction(between(-1, 1), between(-1, 1), between(-0.5, 0.5));
    to.translate = from.translate + way * direction.normalized();
    from.rotate_axis = to.rotate_axis =
        Eigen::Vector3d(between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
    from.rotate_radians = between(0.0, 6.0);
    to.rotate_radians = from.rotate_radians + (between(0.0, 1.0) < 0.5 ? 0.0 : between(-1.0, 1.0));
    if (between(0.0, 1.0) < 0.2)
      object.cloud.opacity.assign(object.cloud.size(), static_cast<float>(between(0.2, 0.9)));
    scene.objects.push_back(std::move(object));
  }
  if (between(0.0, 1.0) < 0.25) {
    LookAtKey later = scene.camera.look_ats.front();
    later.frame = 1.0;
    later.eye += Eigen::Vector3d(between(-0.3, 0.3), between(-0.3, 0.3), between(-0.5, 0.5));
    scene.camera.look_ats.push_back(later);
  }
  return scene;
}

}  // namespace

std::vector<std::string> engine_scene_names() {
  std::vector<std::string> names;
  for (const Entry& entry : entries)
    if (entry.points >= 20'000 && entry.points <= 1'000'000) names.emplace_back(entry.name);
  return names;
}

Result<EngineScene> make_engine_scene(const std::string& name) {
  constexpr std::string_view random = "random-";
  std::uint32_t seed = 0;
  if (name.starts_with(random) &&
      std::from_chars(name.data() + random.size(), name.data() + name.size(), seed).ec == std::errc()) {
    EngineScene made{name, random_scene(seed)};
    if (Status valid = made.scene.validate(); !valid) return valid.error();
    return made;
  }
  for (const Entry& entry : entries) {
    if (name != entry.name) continue;
    EngineScene made{name, entry.make(entry.points, entry.motion_px)};
    if (Status valid = made.scene.validate(); !valid) return valid.error();
    for (const Object& object : made.scene.objects)
      if (object.cloud.size() == 0) return Error{"", "scene", name + ": a generator refused"};
    return made;
  }
  return Error{"", "scene", "there is no scene " + name};
}

}  // namespace swept
