// Where a camera stands that sees a cloud whole. For splat/io's own sources.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "splat/result.h"

namespace swept::io {

/// The axes that a picture of points is seen along. Unit vectors, forward at a right angle to up.
struct Front {
  Eigen::Vector3d up, forward;  ///< forward: into the picture, of one who stands in front
  double above_degrees = 0.0;   ///< how far the camera is raised over the front
  double aside_degrees = 0.0;   ///< how far it is turned to the right
};

struct Framing {
  Eigen::Vector3d eye, target;
  Eigen::Vector3d back;   ///< unit but for rounding, from the target to the eye
  double distance = 0.0;  ///< between the two, > 0
  std::size_t far = 0;    ///< points that are far from the rest and were not looked at
};

/// Sees all points but those far from the rest, which lie beyond the 1st to the 99th percentile of an axis by
/// more than a tenth of that range, and leaves a margin of 5% of the picture on each side. `reach` is how far
/// a point's disc extends. `tan_x` and `tan_y` are tangents of the half fields of view. Precondition: points.
/// Errors (without a file): points too far apart.
[[nodiscard]] Result<Framing> frame_points(const std::vector<Eigen::Vector3d>& points, double reach,
                                           const Front& front, double tan_x, double tan_y);

}  // namespace swept::io
