#include "tools/random_splats.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>

namespace swept {
namespace {

constexpr double middle_depth = 7.0, half_depth = 3.0;

void scatter(std::mt19937& generator, std::size_t count, float size, bool moving, float speed,
             SplatCloud& cloud) {
  std::uniform_real_distribution<float> any(-1.0f, 1.0f);
  const auto next = [&] { return any(generator); };
  cloud.degree = 3;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = middle_depth + half_depth * double{next()}, x = 0.8 * z * double{next()},
                 y = 0.55 * z * double{next()};
    cloud.position.push_back({x, y, z});
    const float longest = size * std::exp(1.5f * next());
    const float second = std::exp(next() - 1.0f), third = std::exp(next() - 1.0f);
    cloud.scale.push_back(longest * Eigen::Vector3f(1.0f, second, third));
    Eigen::Quaternionf turn(next(), next(), next(), next());
    if (!(turn.norm() > 0.1f)) turn.setIdentity();
    cloud.rotation.push_back(turn.normalized());
    cloud.opacity.push_back(0.5f + 0.5f * next());
    for (int k = 0; k < 48; ++k) cloud.harmonics.push_back((k < 3 ? 1.5f : 0.3f) * next());
    if (!moving) continue;
    const float vx = next(), vy = next(), vz = next();
    cloud.velocity.push_back(speed * Eigen::Vector3f(vx, vy, vz));
  }
}

}  // namespace

Scene random_splat_scene(unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  const auto between = [&](double low, double high) { return low * std::pow(high / low, any(generator)); };
  Scene scene;
  scene.film = {192, 128, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  LookAtKey from;
  from.eye = {0, 0, 0}, from.target = {0, 0, middle_depth}, from.up = {0, -1, 0};
  from.tan_half_fov_y = std::tan(25.0 * M_PI / 180.0);
  const auto count = static_cast<std::size_t>(between(300.0, 6000.0));
  const double size = between(0.02, 0.2), px = between(4.0, 100.0);
  const double way = px * 2.0 * from.tan_half_fov_y / scene.film.height * middle_depth;
  LookAtKey to = from;
  to.frame = 1.0;
  constexpr unsigned kinds = 5;
  const unsigned kind = seed % kinds;
  Object& object = scene.objects.emplace_back();
  scatter(generator, count, static_cast<float>(size), kind == 0, static_cast<float>(way), object.splats);
  if (kind == 1) to.eye.x() += way, to.target.x() += way;
  if (kind == 2) to.eye += Eigen::Vector3d(way, 0.3 * way, 0.0);
  if (kind == 3) to.eye.z() += std::min(way, 0.6 * middle_depth);
  if (kind == 4) {
    TransformKey rest, turned;
    turned.frame = 1.0;
    turned.rotate_axis = {0, 0, 1};
    turned.rotate_radians = px / (0.5 * scene.film.height);
    object.transform.keys = {rest, turned};
  }
  scene.camera.look_ats = {from};
  if (kind >= 1 && kind <= 3) scene.camera.look_ats.push_back(to);
  return scene;
}

}  // namespace swept
