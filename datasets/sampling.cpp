#include "datasets/sampling.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace swept::datasets {

void even_out(Eigen::Vector3d& tangent_u, Eigen::Vector3d& tangent_v) {
  const double length_u = tangent_u.norm(), length_v = tangent_v.norm();
  if (length_u == 0.0 || length_v == 0.0) return;
  tangent_u *= std::sqrt(length_v / length_u);
  tangent_v *= std::sqrt(length_u / length_v);
}

double random_unit(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  std::uint64_t z = seed;
  for (const std::uint64_t word : {stream, index}) {
    z += word + 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
  }
  return static_cast<double>(z >> 11) * 0x1p-53;
}

std::vector<std::size_t> apportion(std::size_t points, const std::vector<double>& areas) {
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  std::vector<std::size_t> counts(areas.size()), order(areas.size());
  std::vector<double> remainder(areas.size());
  std::size_t given = 0;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const double share = static_cast<double>(points) * areas[i] / total;
    counts[i] = std::min(static_cast<std::size_t>(share), points - given);
    remainder[i] = share - std::floor(share);
    given += counts[i];
  }
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return remainder[a] > remainder[b]; });
  for (std::size_t i = 0; given < points; i = (i + 1) % order.size(), ++given) ++counts[order[i]];
  return counts;
}

CloudBuilder::CloudBuilder(const Request& request)
    : seed_(request.seed()),
      tint_(request.number("red"), request.number("green"), request.number("blue")),
      ambient_(request.number("ambient")),
      light_(Eigen::Vector3d(request.number("light_x"), request.number("light_y"), request.number("light_z"))
                 .normalized()) {
  const std::size_t n = request.points();
  cloud_.keys.resize(1);
  cloud_.keys[0].pose.position.reserve(n);
  cloud_.keys[0].pose.axis_u.reserve(n);
  cloud_.keys[0].pose.axis_v.reserve(n);
  cloud_.color.reserve(n);
}

void CloudBuilder::add(const SurfaceSample& sample, std::size_t n, Sides sides) {
  const double scale = kDiscRadius / std::sqrt(static_cast<double>(n));
  Eigen::Vector3d a = scale * sample.tangent_u, b = scale * sample.tangent_v;

  // The ellipse's principal axes: a Jacobi rotation that leaves the disc as it is.
  const double angle = 0.5 * std::atan2(2.0 * a.dot(b), a.squaredNorm() - b.squaredNorm());
  const Eigen::Vector3d major = std::cos(angle) * a + std::sin(angle) * b;
  b = std::cos(angle) * b - std::sin(angle) * a;
  a = major;

  double facing = a.cross(b).normalized().dot(light_);
  if (sides == Sides::both) facing = std::abs(facing);
  const double shade = ambient_ + (1.0 - ambient_) * std::max(0.0, facing);

  SurfelPose& pose = cloud_.keys[0].pose;
  pose.position.push_back(sample.position);
  pose.axis_u.push_back(a.cast<float>());
  pose.axis_v.push_back(b.cast<float>());
  cloud_.color.push_back((sample.color.array() * tint_ * shade).matrix().cast<float>());
}

void CloudBuilder::add_particle(const Eigen::Vector3d& position, const Eigen::Vector3d& axis_u,
                                const Eigen::Vector3d& axis_v, const Eigen::Vector3d& velocity,
                                const Eigen::Vector3d& color) {
  SurfelPose& pose = cloud_.keys[0].pose;
  pose.position.push_back(position);
  pose.axis_u.push_back(axis_u.cast<float>());
  pose.axis_v.push_back(axis_v.cast<float>());
  cloud_.velocity.push_back(velocity.cast<float>());
  cloud_.color.push_back((color.array() * tint_).matrix().cast<float>());
}

}  // namespace swept::datasets
