// Hard edges of meshes: where they are, and points of their own for the triangles on either side.
//
// Topology is OpenMesh's, in a build with SWEPT_OPENMESH; others refuse a crease angle by name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "splat/io/cloud_source.h"
#include "splat/result.h"
#include "splat/surfel.h"

namespace swept::io {

/// Whether this build finds hard edges.
[[nodiscard]] bool creases_available();

/// A mesh in which no two triangles that share a point have a hard edge between them all around it.
struct CreasedMesh {
  std::vector<Triangle> triangles;     ///< as they were, in their order; corners may be copies
  std::vector<std::uint32_t> copies;   ///< point n + k is a copy of point copies[k], of n there were
  std::size_t edges = 0;               ///< between two triangles, or at the boundary
  std::size_t hard = 0, boundary = 0;  ///< of these
  /// Triangles that no half-edge mesh takes: beside two others at one edge, facing against a neighbour, or at
  /// a point that others already surround. All edges of theirs are hard.
  std::size_t apart = 0;
};

/// An edge is hard where its triangles' normals differ by more than `crease_radians`; where the file names
/// normals of corners on both sides, instead where these differ at either end. Points at which `smooth` is
/// not 0 get no copies. Triangles without an area have no hard edges. `smooth` and `corners` are empty or
/// have an entry a point and a triangle. Error: a build without OpenMesh, more than its indices can name.
[[nodiscard]] Result<CreasedMesh> crease(const std::vector<Eigen::Vector3d>& positions,
                                         const std::vector<Triangle>& triangles, double crease_radians,
                                         const std::vector<std::uint8_t>& smooth,
                                         const std::vector<CornerNormals>& corners);

/// Gives the triangles on either side of hard edges points of their own, as crease() finds them at key
/// `reference`, with the normals of these triangles at every key, and colours by them where the source has
/// these. Points that are copies follow all others. Error: as crease().
[[nodiscard]] Status split_at_creases(const CloudSource& source, std::size_t reference, LoadedCloud& loaded);

}  // namespace swept::io
