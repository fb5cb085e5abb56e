#include "splat/io/normal_looks.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace swept::io {
namespace {

constexpr float step = 1.0f / 256.0f;
constexpr double turn_between = 0.18;  // radians: half of 1 − cos 0.09 is half a step
constexpr double most_turns = 32.0;

/// When colours are to be known.
std::vector<double> frames_of(const SurfelCloud& cloud, double first, double last) {
  std::vector<double> frames;
  for (const SurfelKey& key : cloud.keys) frames.push_back(key.frame);
  if (frames.size() > 1) return frames;
  double rate = 0.0;
  for (const Eigen::Vector3f& spin : cloud.angular_velocity)
    rate = std::max(rate, spin.cast<double>().stableNorm());
  const double turns = std::min(std::ceil(rate * (last - first) / turn_between), most_turns);
  if (!(turns >= 1.0)) return {};
  frames.clear();
  for (double i = 0.0; i <= turns; ++i) frames.push_back(first + (last - first) * (i / turns));
  return frames;
}

Eigen::Vector3d normal_at(const SurfelsAt& discs, std::size_t i) {
  const SurfelInstant disc = discs[i];
  return disc.axis_u.cross(disc.axis_v).normalized();
}

}  // namespace

void turn_colors(std::size_t reference, double first, double last, SurfelCloud& cloud) {
  const std::vector<double> frames = frames_of(cloud, first, last);
  if (frames.empty() || cloud.color.size() != cloud.size()) return;
  std::vector<LookKey> looks = cloud.looks;
  if (looks.size() != frames.size()) {
    looks.clear();
    for (const double frame : frames) looks.push_back({frame, {}, cloud.opacity});
  }
  const SurfelsAt known(cloud, cloud.keys[reference].frame);
  bool changes = false;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const SurfelsAt discs(cloud, frames[k]);
    std::vector<Eigen::Vector3f> colors(cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3f& color = cloud.color[i];
      const Eigen::Vector3d shown = color.cast<double>() - Eigen::Vector3d::Constant(0.5);
      const double side = shown.dot(normal_at(known, i)) < 0.0 ? -0.5 : 0.5;
      colors[i] = (side * normal_at(discs, i) + Eigen::Vector3d::Constant(0.5)).cast<float>();
      changes = changes || !((colors[i] - color).cwiseAbs().maxCoeff() < step);
    }
    looks[k].color = std::move(colors);
  }
  if (changes) cloud.looks = std::move(looks);
}

}  // namespace swept::io
