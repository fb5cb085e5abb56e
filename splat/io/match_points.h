// The same points in two files, by their ids.
#pragma once

#include <cstddef>

#include "splat/io/point_file.h"
#include "splat/result.h"

namespace swept {

struct MatchedPoints {
  PointSet set;             ///< point i is point i of the reference
  std::size_t missing = 0;  ///< of the reference's points, those that the other file lacks
  std::size_t extra = 0;    ///< of the other file's points, those that the reference lacks: they are left out
};

/// `other` in the order of `reference`; both have ids, each once. Where `other` lacks a point, it has the
/// reference's, moved by `velocity_scale` times its velocity if there are velocities. Triangles are the
/// reference's; velocities and the like are left empty, and so are colours and opacities of which some would
/// be missing. Errors (file left empty): a point is missing and the files differ in which of normals, radii
/// and axes they have.
[[nodiscard]] Result<MatchedPoints> match_by_id(const PointSet& reference, const PointSet& other,
                                                double velocity_scale);

}  // namespace swept
