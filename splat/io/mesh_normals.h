// Normals of meshes that come without (model section 15).
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/io/point_file.h"
#include "splat/surfel.h"

namespace SWEPT_API swept {

/// Of every vertex the unit normals of its triangles, weighted by the angles that these have there, and of
/// unit length again (Thürmer and Wüthrich 1998): so it does not matter how a flat face is cut into
/// triangles. Zero where there are no triangles with an area, or where they cancel. Corners must be vertices.
[[nodiscard]] std::vector<Eigen::Vector3d> mesh_normals(const std::vector<Eigen::Vector3d>& positions,
                                                        const std::vector<Triangle>& triangles);

namespace io {

/// Turns what would be the discs of a mesh's points along the normals of the set, and along mesh_normals()
/// where it has none for a point. Their radii are of no meaning.
void turn_along_normals(const PointSet& set, SurfelPose& pose);

/// Which normals of a mesh are made, in words; nothing where the file has all.
[[nodiscard]] std::string what_normals_are(const PointSet& set);

}  // namespace io
}  // namespace swept
