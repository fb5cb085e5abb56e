#include "splat/motion/segments.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "splat/motion/cut.h"
#include "splat/motion/instant.h"

namespace swept {
namespace {

constexpr double chord_tolerance_px = 0.1;  // chords err to one side, and in the middle most
constexpr double rim_tolerance_px = 0.25;   // frozen axes err to both sides; the mean over the points counts
constexpr int probed_segments = 8;
constexpr std::size_t sample_size = 1024;

/// A number that depends on where a point is and on nothing else.
std::uint64_t mixed(const Eigen::Vector3d& position) {
  std::uint64_t hash = 0x9e3779b97f4a7c15ULL;
  for (const double x : {position.x(), position.y(), position.z()}) {
    hash ^= std::bit_cast<std::uint64_t>(x);
    hash *= 0xbf58476d1ce4e5b9ULL;
    hash ^= hash >> 31;
  }
  return hash;
}

struct Deviation {
  double path_px = 0.0;  ///< the largest
  double rim_px = 0.0;   ///< of one point the largest, of several the sum
  std::size_t points = 0;

  [[nodiscard]] double mean_rim_px() const { return points > 0 ? rim_px / static_cast<double>(points) : 0.0; }
  [[nodiscard]] bool within_tolerance() const {
    return path_px <= chord_tolerance_px && mean_rim_px() <= rim_tolerance_px;
  }
};

/// One point at the ends and middles of probed_segments segments.
struct Probe {
  std::array<Eigen::Vector3d, 2 * probed_segments + 1> center, axis_u, axis_v;
  std::array<double, 2 * probed_segments + 1> time;  ///< of the shutter
};

Deviation deviation_of(const Probe& probe, int segments, const Projection& projection, const Film& film,
                       double near) {
  Deviation deviation;
  const int step = probed_segments / segments;  // from an end to the middle
  for (int s = 0; s < segments; ++s) {
    const int first = 2 * s * step, middle = first + step, last = middle + step;
    const Eigen::Vector3d& truth = probe.center[middle];
    const double length = probe.time[last] - probe.time[first];
    if (!(length > 0.0)) continue;
    const double share = (probe.time[middle] - probe.time[first]) / length;
    const Eigen::Vector3d chord = probe.center[first] + share * (probe.center[last] - probe.center[first]);
    if (!(truth.z() > near)) continue;
    const double per_unit = projection.focal_px / projection.divisor(truth.z());
    // Only what can be seen matters, give or take a frame.
    const double from_middle_x = projection.center_x - 0.5 * film.width + truth.x() * per_unit;
    const double from_middle_y = projection.center_y - 0.5 * film.height + truth.y() * per_unit;
    if (std::abs(from_middle_x) > film.width || std::abs(from_middle_y) > film.height) continue;
    const auto turned = [&](int end) {
      return std::max((probe.axis_u[end] - probe.axis_u[middle]).norm(),
                      (probe.axis_v[end] - probe.axis_v[middle]).norm());
    };
    deviation.path_px = std::max(deviation.path_px, (chord - truth).norm() * per_unit);
    deviation.rim_px = std::max(deviation.rim_px, std::max(turned(first), turned(last)) * per_unit);
    deviation.points = 1;
  }
  return deviation;
}

int choose_segments(const Scene& scene, const Object& object, const Exposure& exposure) {
  std::array<Instant, 2 * probed_segments + 1> instants;
  Probe probe;
  for (int j = 0; j <= 2 * probed_segments; ++j) {
    probe.time[j] = segment_time(exposure, j, 2 * probed_segments);
    instants[j] = instant_at(scene, object, exposure, probe.time[j]);
  }
  const Projection projection = projection_of(scene.film, scene.camera.at(instants[probed_segments].frame));

  std::array<Deviation, 4> by_log2{};
  const SurfelCloud& cloud = object.cloud;
  const std::size_t stride = (cloud.size() + sample_size - 1) / sample_size;
  std::vector<SurfelsAt> surfels;
  if (cloud.size() > 0)
    for (const Instant& instant : instants) surfels.emplace_back(cloud, instant.frame);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (stride > 1 && mixed(cloud.keys.front().pose.position[i]) % stride != 0) continue;
    for (int j = 0; j <= 2 * probed_segments; ++j) {
      const SurfelInstant surfel = surfels[static_cast<std::size_t>(j)][i];
      probe.center[j] = instants[j].to_camera(surfel.position);
      probe.axis_u[j] = instants[j].to_camera_direction(surfel.axis_u);
      probe.axis_v[j] = instants[j].to_camera_direction(surfel.axis_v);
    }
    for (int k = 0; k < 4; ++k) {
      const Deviation d = deviation_of(probe, 1 << k, projection, scene.film, scene.camera.near);
      by_log2[k].path_px = std::max(by_log2[k].path_px, d.path_px);
      by_log2[k].rim_px += d.rim_px;
      by_log2[k].points += d.points;
    }
  }
  if (by_log2[3].within_tolerance()) {
    // From the finest down: whole turns look still where few instants are seen.
    int k = 3;
    while (k > 0 && by_log2[k - 1].within_tolerance()) --k;
    return 1 << k;
  }
  // A chord's error falls with the square of the count, a frozen axis's with the count.
  const double factor = std::max(std::sqrt(by_log2[3].path_px / chord_tolerance_px),
                                 by_log2[3].mean_rim_px() / rim_tolerance_px);
  return static_cast<int>(std::min<double>(std::ceil(probed_segments * factor), max_chosen_segments));
}

}  // namespace

int most_segments(const Scene& scene, const Object& object, const Exposure& exposure) {
  if (!cuts_by_point(scene, object, exposure)) return linear_segments(scene, object, exposure);
  PathCutter cutter(scene, object, exposure.of_all_rows(scene.film.height), SegmentShape::parabolas);
  const SurfelCloud& cloud = object.cloud;
  const std::size_t stride = (cloud.size() + sample_size - 1) / sample_size;
  std::size_t most = 1;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (stride < 2 || mixed(cloud.keys.front().pose.position[i]) % stride == 0)
      most = std::max(most, cutter.cut(i, path_tolerance_px(scene)).size());
  return static_cast<int>(most);
}

double segment_time(const Exposure& exposure, int s, int segments) {
  const double time = static_cast<double>(s) / segments;
  if (!exposure.curve || s == 0 || s == segments) return time;
  return exposure.share_at(exposure.open + (exposure.close - exposure.open) * time);
}

double segment_middle(const Exposure& exposure, int s, int segments) {
  if (!exposure.curve) return (2 * s + 1) / (2.0 * segments);
  return 0.5 * (segment_time(exposure, s, segments) + segment_time(exposure, s + 1, segments));
}

bool nothing_moves(const Scene& scene, const Exposure& exposure) {
  return std::all_of(scene.objects.begin(), scene.objects.end(),
                     [&](const Object& object) { return stands_still(scene, object, exposure); });
}

int linear_segments(const Scene& scene, const Object& object, const Exposure& exposure) {
  if (stands_still(scene, object, exposure)) return 1;
  if (object.segments > 0) return object.segments;
  return scene.model.segments > 0 ? scene.model.segments : choose_segments(scene, object, exposure);
}

}  // namespace swept
