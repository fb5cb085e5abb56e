// Discs for points that come without them: from the triangles around a vertex, or from the nearest points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/io/point_file.h"
#include "splat/result.h"
#include "splat/surfel.h"

namespace SWEPT_API swept {

/// Radius at the kernel's cut-off over the spacing h of a triangular grid. Overlapping Gaussians
/// exp(−δ d²/r²) on that grid sum to a constant with a ripple of 6 exp(−4π² r² / (3δ h²)) (Poisson
/// summation, first shell of the reciprocal grid): 0.6% at δ = 3, and no holes.
inline constexpr double kRadiusPerSpacing = 1.25;

/// Discs, and which of them have a side that is a guess.
struct EstimatedSurfels {
  SurfelPose pose;
  std::vector<std::size_t> unoriented;  ///< points whose a₁ × a₂ may point either way, increasing
  bool oriented = false;  ///< whether a₁ × a₂ of all other points is known to point outside
  std::vector<std::string> notes;
};

/// One disc per vertex of a triangle mesh, in the plane of its area-weighted normal, front to the
/// outside. The axes are the eigenvectors of the one-ring's second moment M = mean(e eᵀ) of the edges e
/// in that plane, with lengths kRadiusPerSpacing · √(2λ): √(2λ) is h on a triangular grid of spacing h. The
/// shorter axis is at least a tenth of the longer. Vertices without triangles of any area are estimated from
/// their nearest points, with the front of the nearest other vertex, and counted in the notes. Errors (file
/// left empty): positions that are not finite, corners that are no vertex, no two distinct points to estimate
/// a lone vertex from, discs beyond the range of float.
[[nodiscard]] Result<EstimatedSurfels> surfels_from_mesh(
    const std::vector<Eigen::Vector3d>& positions,
    const std::vector<std::array<std::uint32_t, 3>>& triangles);

/// One round disc per point. If the set has no normals, a point's normal is that of the plane through its 12
/// nearest distinct points, and unoriented. If it has no radii, a point's radius is kRadiusPerSpacing · the
/// mean distance of its 6 nearest distinct points, at most 10 times the median radius. The notes say what was
/// estimated. Errors (file left empty): as PointSet::validate(), a radius is needed and all points coincide,
/// discs beyond the range of float.
[[nodiscard]] Result<EstimatedSurfels> surfels_from_cloud(const PointSet& points);

}  // namespace swept
