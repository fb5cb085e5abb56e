#include "abuffer/reference/posed_scene.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace swept::reference {
namespace {

using Nine = Eigen::Matrix<double, 9, 1>;  // position and both axes

Nine stacked(const SurfelPose& pose, std::size_t i) {
  Nine all;
  all << pose.position[i], pose.axis_u[i].cast<double>(), pose.axis_v[i].cast<double>();
  return all;
}

/// The parabola through points at times a, b, c, at time t, by Neville's scheme.
Nine parabola(double a, const Nine& at_a, double b, const Nine& at_b, double c, const Nine& at_c, double t) {
  const Nine ab = at_a + (t - a) / (b - a) * (at_b - at_a);
  const Nine bc = at_b + (t - b) / (c - b) * (at_c - at_b);
  return ab + (t - a) / (c - a) * (bc - ab);
}

/// Overhauser's form of the spline: two parabolas, one through the keys up to the stretch's end and one
/// through those from its beginning on, blended from the first to the second; at an end there is only one of
/// them.
Nine on_spline(const SurfelCloud& cloud, std::size_t i, std::size_t k, double frame) {
  const std::vector<SurfelKey>& keys = cloud.keys;
  const auto key = [&](std::size_t at) { return stacked(keys[at].pose, i); };
  const auto through = [&](std::size_t a) {
    return parabola(keys[a].frame, key(a), keys[a + 1].frame, key(a + 1), keys[a + 2].frame, key(a + 2),
                    frame);
  };
  const double share = (frame - keys[k].frame) / (keys[k + 1].frame - keys[k].frame);
  if (keys.size() == 2) return key(k) + share * (key(k + 1) - key(k));
  if (k == 0) return through(0);
  if (k + 2 == keys.size()) return through(k - 1);
  return (1.0 - share) * through(k - 1) + share * through(k);
}

/// Bernstein's polynomials, by products and powers.
Nine on_bezier(const SurfelCloud& cloud, std::size_t i, double frame) {
  const std::vector<SurfelKey>& keys = cloud.keys;
  const auto degree = static_cast<int>(keys.size()) - 1;
  const double t = (frame - keys.front().frame) / (keys.back().frame - keys.front().frame);
  Nine sum = Nine::Zero();
  double choose = 1.0;
  for (int k = 0; k <= degree; ++k) {
    sum += choose * std::pow(t, k) * std::pow(1.0 - t, degree - k) *
           stacked(keys[static_cast<std::size_t>(k)].pose, i);
    choose = choose * (degree - k) / (k + 1);
  }
  return sum;
}

Nine on_keys(const SurfelCloud& cloud, std::size_t i, double frame) {
  const std::vector<SurfelKey>& keys = cloud.keys;
  if (frame <= keys.front().frame) return stacked(keys.front().pose, i);
  if (frame >= keys.back().frame) return stacked(keys.back().pose, i);
  if (cloud.path == KeyPath::bezier) return on_bezier(cloud, i, frame);
  std::size_t k = 0;
  while (keys[k + 1].frame <= frame) ++k;
  if (cloud.path == KeyPath::spline) return on_spline(cloud, i, k, frame);
  const double share = (frame - keys[k].frame) / (keys[k + 1].frame - keys[k].frame);
  return (1.0 - share) * stacked(keys[k].pose, i) + share * stacked(keys[k + 1].pose, i);
}

Nine on_rates(const SurfelCloud& cloud, std::size_t i, double frame) {
  Nine at = stacked(cloud.keys.front().pose, i);
  const double t = frame - cloud.keys.front().frame;
  if (!cloud.velocity.empty()) at.head<3>() += t * cloud.velocity[i].cast<double>();
  if (!cloud.acceleration.empty()) at.head<3>() += t * t / 2.0 * cloud.acceleration[i].cast<double>();
  if (cloud.angular_velocity.empty()) return at;
  const Eigen::Vector3d rate = cloud.angular_velocity[i].cast<double>();
  if (rate.isZero(0.0)) return at;
  // Rodrigues.
  const Eigen::Vector3d axis = rate.stableNormalized();
  const double angle = rate.stableNorm() * t;
  for (const int first : {3, 6}) {
    const Eigen::Vector3d v = at.segment<3>(first);
    at.segment<3>(first) =
        std::cos(angle) * v + std::sin(angle) * axis.cross(v) + (1.0 - std::cos(angle)) * axis.dot(v) * axis;
  }
  return at;
}

}  // namespace

Eigen::Vector4d light_of(const SurfelCloud& cloud, std::size_t i, double frame) {
  const auto premultiplied = [i](const auto& color, const auto& opacity) {
    const double o = opacity.empty() ? 1.0 : double{opacity[i]};
    Eigen::Vector4d light(o, o, o, o);
    if (!color.empty()) light.head<3>() = o * color[i].template cast<double>();
    return light;
  };
  const std::vector<LookKey>& looks = cloud.looks;
  if (looks.empty()) return premultiplied(cloud.color, cloud.opacity);
  // Straight lines, held beyond the ends.
  std::size_t k = 0;
  while (k + 1 < looks.size() && looks[k + 1].frame <= frame) ++k;
  const Eigen::Vector4d from = premultiplied(looks[k].color, looks[k].opacity);
  if (k + 1 == looks.size() || frame <= looks[k].frame) return from;
  const Eigen::Vector4d to = premultiplied(looks[k + 1].color, looks[k + 1].opacity);
  const double length = looks[k + 1].frame - looks[k].frame;
  return (looks[k + 1].frame - frame) / length * from + (frame - looks[k].frame) / length * to;
}

namespace {

SurfelCloud posed(const SurfelCloud& cloud, double frame) {
  SurfelCloud still;
  still.keys.push_back({frame, {}});
  SurfelPose& pose = still.keys.front().pose;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.lifetime.empty() && (frame < cloud.lifetime[i].born || frame >= cloud.lifetime[i].gone))
      continue;
    const Nine at = cloud.keys.size() > 1 ? on_keys(cloud, i, frame) : on_rates(cloud, i, frame);
    pose.position.emplace_back(at.head<3>());
    pose.axis_u.emplace_back(at.segment<3>(3).cast<float>());
    pose.axis_v.emplace_back(at.tail<3>().cast<float>());
    if (!cloud.looks.empty()) {
      const Eigen::Vector4d light = light_of(cloud, i, frame);
      const double per_opacity = light.w() > 0.0 ? 1.0 / light.w() : 0.0;
      still.color.emplace_back((per_opacity * light.head<3>()).cast<float>());
      still.opacity.push_back(static_cast<float>(std::min(1.0, light.w())));
    } else if (!cloud.color.empty()) {
      still.color.push_back(cloud.color[i]);
    }
    if (!cloud.oriented.empty()) still.oriented.push_back(cloud.oriented[i]);
    if (cloud.looks.empty() && !cloud.opacity.empty()) still.opacity.push_back(cloud.opacity[i]);
  }
  return still;
}

}  // namespace

bool has_own_paths(const Scene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(), [](const Object& object) {
    const SurfelCloud& cloud = object.cloud;
    return cloud.path != KeyPath::linear || !cloud.acceleration.empty() || !cloud.angular_velocity.empty() ||
           !cloud.lifetime.empty() || !cloud.looks.empty();
  });
}

PosedScene::PosedScene(const Scene& scene) : scene_(scene), still_(scene) {
  for (Object& object : still_.objects) object.cloud = {};
}

const Scene& PosedScene::at(double frame) {
  // Which may look through another point of its lens.
  still_.camera = scene_.camera;
  for (std::size_t i = 0; i < scene_.objects.size(); ++i)
    if (scene_.objects[i].cloud.size() > 0) still_.objects[i].cloud = posed(scene_.objects[i].cloud, frame);
  return still_;
}

}  // namespace swept::reference
