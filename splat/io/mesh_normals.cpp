#include "splat/io/mesh_normals.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace swept {

std::vector<Eigen::Vector3d> mesh_normals(const std::vector<Eigen::Vector3d>& positions,
                                          const std::vector<Triangle>& triangles) {
  std::vector<Eigen::Vector3d> normals(positions.size(), Eigen::Vector3d::Zero());
  for (const Triangle& triangle : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d& corner = positions[triangle[i]];
      // stableNormalized: squares of tiny edges do not vanish, nor those of long ones overflow.
      const Eigen::Vector3d a = (positions[triangle[(i + 1) % 3]] - corner).stableNormalized();
      const Eigen::Vector3d b = (positions[triangle[(i + 2) % 3]] - corner).stableNormalized();
      const Eigen::Vector3d across = a.cross(b);
      const double sine = across.norm();
      if (sine > 0.0) normals[triangle[i]] += std::atan2(sine, a.dot(b)) / sine * across;
    }
  // What angles of at most π each leave of a sum that cancels.
  constexpr double nothing = 1e-12;
  for (Eigen::Vector3d& normal : normals) {
    const double length = normal.norm();
    normal = length > nothing ? Eigen::Vector3d(normal / length) : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }
  return normals;
}

namespace io {

void turn_along_normals(const PointSet& set, SurfelPose& pose) {
  std::vector<Eigen::Vector3d> made;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    if (!set.normal.empty()) normal = set.normal[i].cast<double>();
    if (normal.isZero(0.0)) {
      if (made.empty()) made = mesh_normals(set.position, set.triangle);
      normal = made[i];
    }
    if (normal.isZero(0.0)) continue;
    const double radius = pose.axis_u[i].cast<double>().stableNorm();
    round_disc(normal, radius, pose.axis_u[i], pose.axis_v[i]);
  }
}

std::string what_normals_are(const PointSet& set) {
  if (set.normal.empty())
    return "there are no normals: those of all triangles about a point, by their angles";
  const auto missing =
      std::count_if(set.normal.begin(), set.normal.end(), [](const auto& n) { return n.isZero(0.0f); });
  if (missing == 0) return "";
  return std::to_string(missing) +
         " points have no normal: those of all triangles about each, by their angles";
}

}  // namespace io
}  // namespace swept
