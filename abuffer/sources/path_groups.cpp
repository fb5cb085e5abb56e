#include "abuffer/sources/path_groups.h"

#include <array>
#include <cmath>

#include "abuffer/parallel.h"
#include "splat/motion/path.h"

namespace swept {
namespace {

constexpr std::uint8_t curved = 1, spins = 2, mortal = 4;

/// Whether a point's keyed path is a straight line, gone along evenly, in every stretch.
class StraightKeys {
 public:
  StraightKeys(const SurfelCloud& cloud, const std::vector<double>& frames) {
    for (std::size_t j = 0; j + 1 < frames.size(); ++j) {
      std::vector<SurfelsAt>& stretch = stretches_.emplace_back();
      for (const PathWeights& control : path_controls(cloud, frames[j], frames[j + 1]))
        stretch.emplace_back(cloud, control);
    }
  }

  [[nodiscard]] bool operator()(std::size_t i) const {
    for (const std::vector<SurfelsAt>& controls : stretches_) {
      const SurfelInstant first = controls.front()[i], last = controls.back()[i];
      const double most = 0x1p-20 * std::sqrt(first.axis_u.squaredNorm() + first.axis_v.squaredNorm());
      for (std::size_t k = 1; k + 1 < controls.size(); ++k) {
        const double share = static_cast<double>(k) / static_cast<double>(controls.size() - 1);
        const SurfelInstant at = controls[k][i];
        const auto off = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& on, const Eigen::Vector3d& b) {
          return (a + share * (b - a) - on).norm();
        };
        if (!(off(first.position, at.position, last.position) <= most &&
              off(first.axis_u, at.axis_u, last.axis_u) <= most &&
              off(first.axis_v, at.axis_v, last.axis_v) <= most))
          return false;
      }
    }
    return true;
  }

 private:
  std::vector<std::vector<SurfelsAt>> stretches_;
};

}  // namespace

std::size_t PathGroup::degree(const SurfelCloud& cloud) const { return curved ? path_degree(cloud) : 1; }

std::vector<PathGroup> path_groups(const SurfelCloud& cloud, const std::vector<double>& frames) {
  const bool moves = frames.size() > 1;
  const bool may_curve = moves && path_degree(cloud) > 1, may_spin = moves && cloud.spins(),
             may_end = !cloud.lifetime.empty();
  std::vector<std::uint8_t> kinds;
  if (may_curve || may_spin || may_end) {
    kinds.resize(cloud.size());
    const StraightKeys straight(cloud, may_curve && cloud.keys.size() > 1 ? frames : std::vector<double>{});
    parallel_for_each_index(cloud.size(), [&](std::size_t i) {
      std::uint8_t kind = 0;
      if (may_curve && !(cloud.keys.size() > 1 ? straight(i) : cloud.acceleration[i].isZero(0.0f)))
        kind |= curved;
      if (may_spin && !cloud.angular_velocity[i].isZero(0.0f)) kind |= spins;
      if (may_end && !(cloud.lifetime[i].born <= frames.front() && frames.back() < cloud.lifetime[i].gone))
        kind |= mortal;
      kinds[i] = kind;
    });
  }
  std::array<std::size_t, 8> counts{};
  for (const std::uint8_t kind : kinds) ++counts[kind];
  if (kinds.empty()) counts[0] = cloud.size();
  std::vector<PathGroup> groups;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    if (counts[kind] == 0) continue;
    PathGroup& group = groups.emplace_back();
    group.curved = (kind & curved) != 0;
    group.spins = (kind & spins) != 0;
    group.mortal = (kind & mortal) != 0;
    if (counts[kind] == cloud.size()) {
      group.points.resize(cloud.size());
      parallel_for_each_index(cloud.size(),
                              [&](std::size_t i) { group.points[i] = static_cast<std::uint32_t>(i); });
      continue;
    }
    group.points.reserve(counts[kind]);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (kinds[i] == kind) group.points.push_back(static_cast<std::uint32_t>(i));
  }
  return groups;
}

}  // namespace swept
