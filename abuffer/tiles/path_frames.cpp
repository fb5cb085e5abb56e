#include "abuffer/tiles/path_frames.h"

#include <algorithm>
#include <cmath>

namespace swept {
namespace {

/// Radians by which object or camera turn from one frame to the next at which a path is looked at.
constexpr double most_turn = 0.25;

/// Angle by which `object` and camera turn over the exposure, radians, or more.
double turning(const Scene& scene, const Object& object, const Exposure& exposure) {
  const auto over = [&](const auto& keys, const auto& angle) {
    double sum = 0.0;
    for (std::size_t i = 1; i < keys.size(); ++i) {
      const double first = std::max(keys[i - 1].frame, exposure.open),
                   last = std::min(keys[i].frame, exposure.close);
      if (first < last)
        sum += angle(keys[i - 1], keys[i]) * (last - first) / (keys[i].frame - keys[i - 1].frame);
    }
    return sum;
  };
  // Keys of different axes are joined by the shorter arc.
  const double of_object = over(object.transform.keys, [](const TransformKey& a, const TransformKey& b) {
    return std::max(std::abs(b.rotate_radians - a.rotate_radians),
                    (a.rotate_axis - b.rotate_axis).norm() > 0.0 ? M_PI : 0.0);
  });
  const double of_poses = over(scene.camera.poses, [](const CameraKey& a, const CameraKey& b) {
    return a.world_from_camera.angularDistance(b.world_from_camera);
  });
  const double of_looks = over(scene.camera.look_ats, [](const LookAtKey& a, const LookAtKey& b) {
    return std::abs(b.roll_radians - a.roll_radians);
  });
  return of_object + of_poses + of_looks;
}

/// A camera that looks at something passing by turns fast where it is near: [first, last] is halved until it
/// turns little in each part. Appends where parts begin.
void halve_looks(const Scene& scene, double first, double last, int most_halvings, std::vector<double>& out) {
  const auto facing = [&](double frame) {
    return Eigen::Quaterniond(scene.camera.at(frame).camera_from_world.linear());
  };
  const double middle = 0.5 * first + 0.5 * last;
  if (most_halvings == 0 || !(first < middle && middle < last) ||
      !(facing(first).angularDistance(facing(last)) > 0.5 * most_turn)) {
    out.push_back(first);
    return;
  }
  halve_looks(scene, first, middle, most_halvings - 1, out);
  halve_looks(scene, middle, last, most_halvings - 1, out);
}

}  // namespace

std::vector<double> path_frames(const Scene& scene, const Object& object,
                                const std::vector<double>& of_points, const Exposure& exposure) {
  constexpr double most = 2048.0;
  const double turns = std::ceil(turning(scene, object, exposure) / most_turn);
  if (!(turns <= most)) return {};
  std::vector<double> frames(of_points);
  const int steps = std::max(1, static_cast<int>(turns));
  for (int i = 0; i <= steps; ++i) frames.push_back(exposure.at(static_cast<double>(i) / steps));
  const auto add_keys = [&](const auto& keys) {
    for (const auto& key : keys)
      if (key.frame > exposure.open && key.frame < exposure.close) frames.push_back(key.frame);
  };
  add_keys(object.transform.keys);
  add_keys(scene.camera.poses);
  add_keys(scene.camera.look_ats);
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  if (static_cast<double>(frames.size()) > 2.0 * most) return {};
  if (scene.camera.look_ats.size() < 2) return frames;
  std::vector<double> halved;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i)
    halve_looks(scene, frames[i], frames[i + 1], 24, halved);
  halved.push_back(frames.back());
  return halved;
}

}  // namespace swept
