// Clouds of the Point Cloud Library in and out, for programs that hold their points in them. This header and
// the target swept::pcl need PCL (its common component); the rest of Swept does not.
//
// What is read of a point is what its type has, by name: x y z; normal_x normal_y normal_z; r g b, as sRGB;
// radius; vx vy vz. Types of the caller's own will do. Intensity and alpha are left unread.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <Eigen/Core>

#include "splat/export.h"
#include "splat/io/cloud_source.h"
#include "splat/io/point_file.h"
#include "splat/result.h"
#include "splat/surfel.h"

namespace SWEPT_API swept {

template <class P>
concept PclPosition = requires(P p) {
  p.x = 0.0f, p.y = 0.0f, p.z = 0.0f;
};
template <class P>
concept PclNormal = requires(P p) {
  p.normal_x = 0.0f, p.normal_y = 0.0f, p.normal_z = 0.0f;
};
template <class P>
concept PclColor = requires(P p) {
  p.r = std::uint8_t{0}, p.g = std::uint8_t{0}, p.b = std::uint8_t{0};
};
template <class P>
concept PclRadius = requires(P p) {
  p.radius = 0.0f;
};
template <class P>
concept PclVelocity = requires(P p) {
  p.vx = 0.0f, p.vy = 0.0f, p.vz = 0.0f;
};
template <class P>
concept PclIntensity = requires(P p) {
  p.intensity;
};

/// What the templates below leave to the library, so that they stay short.
namespace pcl_parts {

/// A cloud taken apart point by point, before anything is known about it as a whole.
struct Taken {
  PointSet points;
  std::size_t total = 0;           ///< points of the cloud
  std::size_t without_normal = 0;  ///< points whose normal is not finite
  bool posed = false;              ///< a sensor pose that is not the identity
  bool intensity = false;
};
[[nodiscard]] Result<PointSet> finish(Taken taken);
[[nodiscard]] Error not_finite(std::size_t point);

[[nodiscard]] Eigen::Vector3f linear_of_bytes(std::uint8_t r, std::uint8_t g, std::uint8_t b);

/// A disc as a PCL point says it. Colour is sRGB, and opacity is not said.
struct Given {
  Eigen::Vector3f position, normal;
  std::array<std::uint8_t, 3> color;
  float radius;
};
[[nodiscard]] Result<std::vector<Given>> take_apart(const SurfelCloud& cloud, double frame,
                                                    const Eigen::Vector3d& origin);

}  // namespace pcl_parts

/// The points of `cloud`, as a file would give them. Normals that are not finite count as not given, and so
/// do radii that are all zero. A sensor pose is not applied. The notes say all this. Errors: no points; a
/// position, velocity or radius that is not finite, unless `skip_invalid` drops that point; negative radii.
template <PclPosition P>
[[nodiscard]] Result<PointSet> points_from_pcl(const pcl::PointCloud<P>& cloud, bool skip_invalid = false) {
  pcl_parts::Taken taken;
  taken.total = cloud.size();
  taken.posed =
      !cloud.sensor_origin_.template head<3>().isZero(0.0f) || !cloud.sensor_orientation_.vec().isZero(0.0f);
  taken.intensity = PclIntensity<P>;
  PointSet& set = taken.points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const P& p = cloud[i];
    bool finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    if constexpr (PclVelocity<P>) {
      finite = finite && std::isfinite(p.vx) && std::isfinite(p.vy) && std::isfinite(p.vz);
    }
    if constexpr (PclRadius<P>) finite = finite && std::isfinite(p.radius);
    if (!finite && skip_invalid) continue;
    if (!finite) return pcl_parts::not_finite(i);

    set.position.emplace_back(p.x, p.y, p.z);
    if constexpr (PclVelocity<P>) set.velocity.emplace_back(p.vx, p.vy, p.vz);
    if constexpr (PclRadius<P>) set.radius.push_back(p.radius);
    if constexpr (PclColor<P>) set.color.push_back(pcl_parts::linear_of_bytes(p.r, p.g, p.b));
    if constexpr (PclNormal<P>) {
      const Eigen::Vector3f normal(p.normal_x, p.normal_y, p.normal_z);
      if (!normal.allFinite()) ++taken.without_normal;
      set.normal.push_back(normal.allFinite() ? normal : Eigen::Vector3f::Zero());
    }
  }
  return pcl_parts::finish(std::move(taken));
}

/// The points of `cloud` as discs, at `frame`: cloud_from_points() of points_from_pcl(). Normals and radii
/// that the cloud does not give are estimated. Errors: as the two functions.
template <PclPosition P>
[[nodiscard]] Result<LoadedCloud> cloud_from_pcl(const pcl::PointCloud<P>& cloud, double frame,
                                                 const CloudSource& source = {}) {
  Result<PointSet> points = points_from_pcl(cloud, source.skip_invalid);
  if (!points) return points.error();
  return cloud_from_points(*std::move(points), frame, source);
}

/// The discs of `cloud` at `frame` as points of PCL. Those of these members that the type P has are filled:
/// the position less `origin` (PCL's coordinates are floats), the unit normal (zero if the disc has no area),
/// the colour in sRGB, clipped to [0, 1], and the radius of the round disc of the same area. Errors: as
/// SurfelCloud::validate(), a frame or an origin that is not finite, a position beyond the range of float.
template <PclPosition P = pcl::PointSurfel>
[[nodiscard]] Result<pcl::PointCloud<P>> pcl_from_cloud(const SurfelCloud& cloud, double frame,
                                                        const Eigen::Vector3d& origin = {0, 0, 0}) {
  const Result<std::vector<pcl_parts::Given>> discs = pcl_parts::take_apart(cloud, frame, origin);
  if (!discs) return discs.error();
  pcl::PointCloud<P> points;
  points.reserve(discs->size());
  for (const pcl_parts::Given& disc : *discs) {
    P p;
    p.x = disc.position.x(), p.y = disc.position.y(), p.z = disc.position.z();
    if constexpr (PclNormal<P>) {
      p.normal_x = disc.normal.x(), p.normal_y = disc.normal.y(), p.normal_z = disc.normal.z();
    }
    if constexpr (PclColor<P>) {
      p.r = disc.color[0], p.g = disc.color[1], p.b = disc.color[2];
      if constexpr (requires { p.a = std::uint8_t{255}; }) p.a = 255;
    }
    if constexpr (PclRadius<P>) p.radius = disc.radius;
    points.push_back(p);
  }
  return points;
}

}  // namespace swept
