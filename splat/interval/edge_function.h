// The edge of a triangle whose corners move on Bézier curves, as the viewing rays see it over time.
//
// Source: Gribel et al. 2013, Eq. 1 to 4. With corners p(t) and q(t) of degree n in camera space the edge is
// the plane through the eye with the normal p × q, which is a Bézier curve of degree 2n; e = (p × q)·ray has
// one sign on either side of the edge. Edges are planes through the eye, so that a corner may pass through
// it or behind it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "splat/export.h"
#include "splat/interval/bernstein.h"

namespace SWEPT_API swept {

inline constexpr int most_path_degree = 3;

/// Control points of a Bézier curve, camera space.
using PathPoints = std::array<Eigen::Vector3d, most_path_degree + 1>;

class EdgeFunction {
 public:
  EdgeFunction() = default;
  /// From `p` to `q`; of `degree` + 1 control points each, 1 ≤ degree ≤ most_path_degree.
  EdgeFunction(const PathPoints& p, const PathPoints& q, int degree);

  /// Over the time of the paths, of the ray (x, y, 1). The edge from q to p has exactly the negative.
  [[nodiscard]] Bernstein at(const Eigen::Vector3d& ray) const {
    Bernstein e;
    e.degree = degree_;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(degree_); ++k)
      e.c[k] = normals_[k].x() * ray.x() + (normals_[k].y() * ray.y() + normals_[k].z());
    return e;
  }

  /// Where e changes its sign. A ray that the edge passes through all the time has the sign that it has a
  /// little to the right of it, or below where that is on the edge, too. It is one function for both of the
  /// triangles that share the edge, but for the sign: of the two, at any time, one has the ray on its side.
  [[nodiscard]] SignChanges sides(const Eigen::Vector3d& ray) const;

  /// By which e changes at most within a rectangle of rays about any, |dx| ≤ half_x, |dy| ≤ half_y.
  [[nodiscard]] double variation(std::size_t k, double half_x, double half_y) const {
    return std::abs(normals_[k].x()) * half_x + std::abs(normals_[k].y()) * half_y;
  }
  [[nodiscard]] int degree() const { return degree_; }
  [[nodiscard]] const Eigen::Vector3d& normal(std::size_t k) const { return normals_[k]; }

 private:
  int degree_ = 0;
  std::array<Eigen::Vector3d, 2 * most_path_degree + 1> normals_;  ///< of the edge, control points
};

}  // namespace swept
