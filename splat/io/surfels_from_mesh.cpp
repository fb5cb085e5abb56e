// One-rings straight from the list of triangles: files hold triangles that share an edge three times or
// turn the wrong way, and a half-edge mesh leaves those out. Discs need no more of topology than neighbours.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "splat/io/check_points.h"
#include "splat/io/guarded.h"
#include "splat/io/nearest_point.h"
#include "splat/io/neighbourhood.h"
#include "splat/io/surfel_estimate.h"

namespace swept {
namespace {

using Positions = std::vector<Eigen::Vector3d>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Width over length of a disc, at the least: narrower ones vanish between the pixels.
constexpr double kLeastAspect = 0.1;
/// |sum of area vectors| over sum of areas below which a vertex has no side: its triangles cancel.
constexpr double kLeastFlatness = 1e-6;

/// For each vertex the vertices it shares a triangle with, as one array cut by offsets; with repeats.
struct OneRings {
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> neighbour;

  OneRings(std::size_t vertices, const Triangles& triangles) : begin(vertices + 1, 0) {
    for (const auto& t : triangles) {
      for (const std::uint32_t corner : t) begin[corner + std::size_t{1}] += 2;
    }
    for (std::size_t v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
    neighbour.resize(begin.back());
    std::vector<std::size_t> end(begin.begin(), begin.end() - 1);
    for (const auto& t : triangles) {
      for (std::size_t c = 0; c < 3; ++c) {
        neighbour[end[t[c]]++] = t[(c + 1) % 3];
        neighbour[end[t[c]]++] = t[(c + 2) % 3];
      }
    }
  }
};

/// The disc of vertex v; false where its ring spans no area. `ring` is in no order and has repeats; they are
/// removed.
bool fit_ring(const Positions& positions, std::size_t v, const Eigen::Vector3d& normal,
              std::vector<std::uint32_t>& ring, Eigen::Vector3f& axis_u, Eigen::Vector3f& axis_v) {
  std::sort(ring.begin(), ring.end());
  ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  const Eigen::Vector3d t = normal.unitOrthogonal(), b = normal.cross(t);
  Eigen::Matrix2d moment = Eigen::Matrix2d::Zero();
  int edges = 0;
  for (const std::uint32_t other : ring) {
    const Eigen::Vector3d edge = positions[other] - positions[v];
    if (edge.isZero(0.0)) continue;
    const Eigen::Vector2d q(edge.dot(t), edge.dot(b));
    moment += q * q.transpose();
    ++edges;
  }
  if (edges == 0) return false;
  moment /= edges;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(moment);
  const double longest = kRadiusPerSpacing * std::sqrt(2.0 * std::max(0.0, solver.eigenvalues()[1]));
  const double across = kRadiusPerSpacing * std::sqrt(2.0 * std::max(0.0, solver.eigenvalues()[0]));
  if (!(longest > 0.0)) return false;
  const Eigen::Vector2d e = solver.eigenvectors().col(1);
  const Eigen::Vector3d u = e.x() * t + e.y() * b;
  axis_u = (longest * u).cast<float>();
  axis_v = (std::max(across, kLeastAspect * longest) * normal.cross(u)).cast<float>();
  return true;
}

double median_length(const PointArray<Eigen::Vector3f>& axes, const std::vector<std::size_t>& left_out) {
  std::vector<float> lengths;
  for (std::size_t i = 0, k = 0; i < axes.size(); ++i) {
    if (k < left_out.size() && left_out[k] == i) {
      ++k;
    } else {
      lengths.push_back(axes[i].norm());
    }
  }
  if (lengths.empty()) return 0.0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return static_cast<double>(*middle);
}

/// The vertices that are not in `left_out`, which is increasing.
std::vector<std::size_t> others(std::size_t count, const std::vector<std::size_t>& left_out) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0, k = 0; i < count; ++i) {
    if (k < left_out.size() && left_out[k] == i)
      ++k;
    else
      others.push_back(i);
  }
  return others;
}

/// Discs for the vertices no triangle speaks for, no larger than half of the mesh's own are, on the side that
/// the triangles of the nearest other vertex have for their front.
Status fit_lone(const Positions& positions, const Positions& normal, EstimatedSurfels& surfels) {
  const Neighbourhood neighbourhood(positions);
  const double most = median_length(surfels.pose.axis_u, surfels.unoriented);
  std::vector<std::size_t> sided = others(positions.size(), surfels.unoriented);
  std::optional<NearestPoint> nearest;
  if (!sided.empty()) nearest.emplace(positions, std::move(sided));
  for (const std::size_t v : surfels.unoriented) {
    const LocalFit fit = neighbourhood.fit(v);
    if (!(fit.spacing > 0.0)) return Error{"", "radius", "all points coincide, so none can be estimated"};
    const double radius = kRadiusPerSpacing * fit.spacing;
    const bool other_side = nearest && fit.normal.dot(normal[nearest->to(positions[v])]) < 0.0;
    round_disc(other_side ? Eigen::Vector3d(-fit.normal) : fit.normal,
               most > 0.0 ? std::min(radius, most) : radius, surfels.pose.axis_u[v], surfels.pose.axis_v[v]);
  }
  return Done{};
}

}  // namespace

Result<EstimatedSurfels> surfels_from_mesh(const Positions& positions, const Triangles& triangles) {
  return io::guarded("", [&]() -> Result<EstimatedSurfels> {
    const std::size_t count = positions.size();
    if (Status s = check_positions(positions); !s) return s.error();
    if (Status s = check_triangles(triangles, count); !s) return s.error();
    Positions normal(count, Eigen::Vector3d::Zero());
    std::vector<double> area(count, 0.0);
    for (const auto& [a, b, c] : triangles) {
      const Eigen::Vector3d n = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
      for (const std::uint32_t corner : {a, b, c}) {
        normal[corner] += n;
        area[corner] += n.norm();
      }
    }

    EstimatedSurfels surfels;
    surfels.oriented = true;
    surfels.pose.position = positions;
    surfels.pose.axis_u.assign(count, Eigen::Vector3f::Zero());
    surfels.pose.axis_v.assign(count, Eigen::Vector3f::Zero());
    const OneRings rings(count, triangles);
    std::vector<std::uint32_t> ring;
    for (std::size_t v = 0; v < count; ++v) {
      ring.assign(rings.neighbour.begin() + static_cast<std::ptrdiff_t>(rings.begin[v]),
                  rings.neighbour.begin() + static_cast<std::ptrdiff_t>(rings.begin[v + 1]));
      const bool has_side = normal[v].norm() > kLeastFlatness * area[v];
      if (!has_side || !fit_ring(positions, v, normal[v].stableNormalized(), ring, surfels.pose.axis_u[v],
                                 surfels.pose.axis_v[v])) {
        surfels.unoriented.push_back(v);
      }
    }
    if (!surfels.unoriented.empty()) {
      if (Status s = fit_lone(positions, normal, surfels); !s) return s.error();
      surfels.notes.push_back(std::to_string(surfels.unoriented.size()) +
                              " vertices without triangles of any area, estimated from their nearest points");
    }
    if (Status s = check_axes(surfels.pose); !s) return s.error();
    return surfels;
  });
}

}  // namespace swept
