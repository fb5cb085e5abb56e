// Hard edges by half-edges. OpenMesh says what shares an edge, what goes around a point and what is a
// boundary.
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <OpenMesh/Core/Mesh/TriConnectivity.hh>

#include "splat/io/mesh_creases.h"

namespace swept::io {
namespace {

using Mesh = OpenMesh::TriConnectivity;
using OpenMesh::HalfedgeHandle, OpenMesh::VertexHandle;

/// Beyond what rounding makes of an angle that is given exactly, as 90° of a box.
constexpr double rounding_radians = 1e-6;
/// Normals of corners that differ by less are the same: digits of files differ.
constexpr float same_normal = 1e-3f;

VertexHandle point_of(std::uint32_t corner) { return VertexHandle(static_cast<int>(corner)); }

/// Whether add_face() would take it. Asked first, for where it would not it prints.
bool fits(const Mesh& mesh, const Triangle& triangle) {
  std::array<HalfedgeHandle, 3> edge;
  for (std::size_t i = 0; i < 3; ++i) {
    const VertexHandle from = point_of(triangle[i]), to = point_of(triangle[(i + 1) % 3]);
    if (from == to || !mesh.is_boundary(from)) return false;
    edge[i] = mesh.find_halfedge(from, to);
    if (edge[i].is_valid() && !mesh.is_boundary(edge[i])) return false;
  }
  // Two edges that are there already, with other triangles between them: these must fit into another gap.
  for (std::size_t i = 0; i < 3; ++i) {
    const HalfedgeHandle before = edge[i], after = edge[(i + 1) % 3];
    if (!before.is_valid() || !after.is_valid() || mesh.next_halfedge_handle(before) == after) continue;
    HalfedgeHandle gap = mesh.opposite_halfedge_handle(after);
    do gap = mesh.opposite_halfedge_handle(mesh.next_halfedge_handle(gap));
    while (!mesh.is_boundary(gap));
    if (gap == before) return false;
  }
  return true;
}

class Creases {
 public:
  Creases(const std::vector<Eigen::Vector3d>& positions, const std::vector<Triangle>& triangles,
          double crease_radians, const std::vector<CornerNormals>& corners)
      : triangles_(triangles), corners_(corners), crease_radians_(crease_radians) {
    mesh_.reserve(positions.size(), triangles.size() + positions.size(), triangles.size());
    for (std::size_t i = 0; i < positions.size(); ++i) mesh_.add_vertex();
    normals_.reserve(triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      // Sides of length 1 each: no square of theirs vanishes or overflows.
      normals_.push_back((positions[b] - positions[a])
                             .stableNormalized()
                             .cross((positions[c] - positions[a]).stableNormalized())
                             .stableNormalized());
      if (!fits(mesh_, triangles[t])) {
        apart_.push_back(t);
        continue;
      }
      mesh_.add_face(point_of(a), point_of(b), point_of(c));
      triangle_of_.push_back(t);
    }
  }

  CreasedMesh split(const std::vector<std::uint8_t>& smooth) {
    CreasedMesh result;
    result.triangles = triangles_;
    result.apart = apart_.size();
    count_edges(result);
    const std::size_t count = mesh_.n_vertices();
    // Who keeps the point itself, where triangles stand apart: the first of all that have it.
    std::vector<std::uint8_t> taken(count, 0);
    for (std::uint32_t v = 0; v < count; ++v)
      if (smooth.empty() || smooth[v] == 0) split_at(v, result, taken[v]);
    for (const std::uint32_t t : apart_)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t v = triangles_[t][c];
        if (!smooth.empty() && smooth[v] != 0) continue;
        if (taken[v] != 0) result.triangles[t][c] = copy(v, result);
        taken[v] = 1;
      }
    return result;
  }

 private:
  [[nodiscard]] std::uint32_t triangle_at(HalfedgeHandle edge) const {
    return triangle_of_[static_cast<std::size_t>(mesh_.face_handle(edge).idx())];
  }
  [[nodiscard]] const Eigen::Vector3f& corner_normal(std::uint32_t triangle, std::uint32_t point) const {
    const Triangle& corners = triangles_[triangle];
    return corners_[triangle][corners[0] == point ? 0 : corners[1] == point ? 1 : 2];
  }

  [[nodiscard]] bool hard(HalfedgeHandle edge) const {
    const HalfedgeHandle other = mesh_.opposite_halfedge_handle(edge);
    if (mesh_.is_boundary(edge) || mesh_.is_boundary(other)) return true;
    const std::uint32_t s = triangle_at(edge), t = triangle_at(other);
    if (!corners_.empty()) {
      bool named = true, differ = false;
      for (const VertexHandle end : {mesh_.from_vertex_handle(edge), mesh_.to_vertex_handle(edge)}) {
        const auto point = static_cast<std::uint32_t>(end.idx());
        const Eigen::Vector3f &a = corner_normal(s, point), &b = corner_normal(t, point);
        named = named && !a.isZero(0.0f) && !b.isZero(0.0f);
        differ = differ || (a - b).norm() > same_normal;
      }
      if (named) return differ;
    }
    const Eigen::Vector3d &a = normals_[s], &b = normals_[t];
    if (a.isZero(0.0) || b.isZero(0.0)) return false;
    return std::atan2(a.cross(b).norm(), a.dot(b)) > crease_radians_ + rounding_radians;
  }

  void count_edges(CreasedMesh& result) {
    result.edges = mesh_.n_edges();
    hard_.resize(mesh_.n_edges());
    for (std::size_t e = 0; e < hard_.size(); ++e) {
      const HalfedgeHandle edge = mesh_.halfedge_handle(OpenMesh::EdgeHandle(static_cast<int>(e)), 0);
      const bool at_boundary =
          mesh_.is_boundary(edge) || mesh_.is_boundary(mesh_.opposite_halfedge_handle(edge));
      hard_[e] = hard(edge) ? 1 : 0;
      if (at_boundary)
        ++result.boundary;
      else
        result.hard += hard_[e];
    }
  }
  [[nodiscard]] bool is_hard(HalfedgeHandle edge) const {
    return hard_[static_cast<std::size_t>(mesh_.edge_handle(edge).idx())] != 0;
  }

  [[nodiscard]] std::uint32_t copy(std::uint32_t point, CreasedMesh& result) const {
    result.copies.push_back(point);
    return static_cast<std::uint32_t>(mesh_.n_vertices() + result.copies.size() - 1);
  }

  /// Goes once around a point, from one hard edge to the next.
  void split_at(std::uint32_t point, CreasedMesh& result, std::uint8_t& taken) const {
    const HalfedgeHandle any = mesh_.halfedge_handle(point_of(point));
    if (!any.is_valid()) return;
    // Counter-clockwise: the triangle of an edge lies between it and the next one.
    const auto next = [&](HalfedgeHandle edge) {
      return mesh_.opposite_halfedge_handle(mesh_.prev_halfedge_handle(edge));
    };
    HalfedgeHandle first = any;
    while (!is_hard(first))
      if (first = next(first); first == any) break;
    taken = 1;
    if (!is_hard(first)) return;
    // Whoever comes first in the file keeps the point.
    std::uint32_t lowest = std::numeric_limits<std::uint32_t>::max();
    HalfedgeHandle keeps = first, begin = first, edge = first;
    do {
      if (is_hard(edge)) begin = edge;
      if (!mesh_.is_boundary(edge) && triangle_at(edge) < lowest) lowest = triangle_at(edge), keeps = begin;
      edge = next(edge);
    } while (edge != first);
    std::uint32_t name = point;
    do {
      if (is_hard(edge) && !mesh_.is_boundary(edge)) name = edge == keeps ? point : copy(point, result);
      if (!mesh_.is_boundary(edge)) {
        const std::uint32_t t = triangle_at(edge);
        for (std::size_t c = 0; c < 3; ++c)
          if (triangles_[t][c] == point) result.triangles[t][c] = name;
      }
      edge = next(edge);
    } while (edge != first);
  }

  const std::vector<Triangle>& triangles_;
  const std::vector<CornerNormals>& corners_;
  double crease_radians_;
  Mesh mesh_;
  std::vector<Eigen::Vector3d> normals_;    ///< of triangles; zero where they have no area
  std::vector<std::uint32_t> triangle_of_;  ///< by face of mesh_
  std::vector<std::uint32_t> apart_;        ///< triangles that it does not take
  std::vector<std::uint8_t> hard_;          ///< by edge
};

}  // namespace

bool creases_available() { return true; }

Result<CreasedMesh> crease(const std::vector<Eigen::Vector3d>& positions,
                           const std::vector<Triangle>& triangles, double crease_radians,
                           const std::vector<std::uint8_t>& smooth,
                           const std::vector<CornerNormals>& corners) {
  // Half-edges, and points with their copies, are numbered by 31 bits; there are at most six and three a
  // triangle.
  constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
  if (triangles.size() > most / 6 || positions.size() > most - 3 * triangles.size())
    return Error{"", "crease_angle", "the mesh has more triangles than OpenMesh can name half-edges of",
                 ErrorKind::unsupported};
  return Creases(positions, triangles, crease_radians, corners).split(smooth);
}

}  // namespace swept::io
