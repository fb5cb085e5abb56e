// A viewing ray and a triangle, the plain way.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "abuffer/reference/reference_frame.h"

namespace swept::reference {

struct RayHit {
  double depth;
  Eigen::Vector3d share;  ///< of the corners
};

/// Möller and Trumbore 1997.
[[nodiscard]] inline std::optional<RayHit> meet_triangle(const Eigen::Vector3d (&p)[3], const Ray& viewing,
                                                         double near) {
  const Eigen::Vector3d& ray = viewing.direction;
  const Eigen::Vector3d e1 = p[1] - p[0], e2 = p[2] - p[0], h = ray.cross(e2);
  const double a = e1.dot(h);
  if (a == 0.0) return std::nullopt;
  const Eigen::Vector3d from = viewing.from - p[0];
  const double u = from.dot(h) / a;
  if (!(u >= 0.0 && u <= 1.0)) return std::nullopt;
  const Eigen::Vector3d q = from.cross(e1);
  const double v = ray.dot(q) / a;
  if (!(v >= 0.0 && u + v <= 1.0)) return std::nullopt;
  const double depth = e2.dot(q) / a;
  if (!(depth >= near)) return std::nullopt;
  return RayHit{depth, {1.0 - u - v, u, v}};
}

}  // namespace swept::reference
