#include "splat/io/pcl/point_cloud.h"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>

#include "splat/srgb.h"

namespace swept::pcl_parts {

Result<PointSet> finish(Taken taken) {
  PointSet& points = taken.points;
  if (std::all_of(points.radius.begin(), points.radius.end(), [](float r) { return r == 0.0f; })) {
    if (!points.radius.empty()) points.notes.emplace_back("the radii are all zero, and count as not given");
    points.radius.clear();
  }
  if (taken.without_normal > 0) {
    points.notes.push_back(std::to_string(taken.without_normal) +
                           " normals are not finite, and count as not given");
  }
  if (const std::size_t dropped = taken.total - points.size(); dropped > 0) {
    points.notes.push_back("dropped " + std::to_string(dropped) + " of " + std::to_string(taken.total) +
                           " points for numbers that are not finite");
  }
  if (taken.intensity) points.notes.emplace_back("the intensity is left unread");
  if (taken.posed) points.notes.emplace_back("the cloud's sensor pose is not applied");
  if (Status s = points.validate(); !s) return s.error();
  return std::move(points);
}

Error not_finite(std::size_t point) {
  return {"", "position[" + std::to_string(point) + "]",
          "or its radius or velocity is not finite; skip_invalid drops such points"};
}

Eigen::Vector3f linear_of_bytes(std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  const auto linear = [](std::uint8_t byte) { return static_cast<float>(srgb_to_linear(byte / 255.0)); };
  return {linear(r), linear(g), linear(b)};
}

Result<std::vector<Given>> take_apart(const SurfelCloud& cloud, double frame, const Eigen::Vector3d& origin) {
  if (Status s = cloud.validate(); !s) return s.error();
  if (!std::isfinite(frame)) return Error{"", "frame", "is not finite"};
  if (!origin.allFinite()) return Error{"", "origin", "is not finite"};
  std::vector<Given> discs;
  discs.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const SurfelInstant disc = surfel_at(cloud, i, frame);
    const Eigen::Vector3d position = disc.position - origin, front = disc.axis_u.cross(disc.axis_v);
    if (!(position.cwiseAbs().maxCoeff() <= std::numeric_limits<float>::max())) {
      return Error{"", "position[" + std::to_string(i) + "]", "is beyond the range of float"};
    }
    const Eigen::Vector3f color = cloud.color.empty() ? Eigen::Vector3f::Ones() : cloud.color[i];
    discs.push_back({position.cast<float>(),
                     front.stableNormalized().cast<float>(),
                     {srgb_byte(color.x()), srgb_byte(color.y()), srgb_byte(color.z())},
                     static_cast<float>(std::sqrt(front.stableNorm()))});
  }
  return discs;
}

}  // namespace swept::pcl_parts
