// Conservative bounds of a moving kernel on the film.
//
// Source: model section 6; Heinzle et al. 2010, section 4.3 and Fig. 5. The tube a disc sweeps in linear
// motion is the convex hull of its two ends, and so is its projection: at most an octagon, the hull of two
// boxes. The hull of two convex sets is the union of their linear blends, so the octagon is kept as a box
// that moves.
#pragma once

#include "splat/camera.h"
#include "splat/export.h"
#include "splat/kernel/moving_kernel.h"

namespace SWEPT_API swept {

/// Closed axis-aligned box on the film, px.
struct PixelBox {
  double x_min = 0.0, x_max = 0.0, y_min = 0.0, y_max = 0.0;
};

/// The convex hull of the two boxes.
struct Octagon {
  PixelBox begin, end;

  [[nodiscard]] PixelBox box() const;
  /// Whether the octagon touches the given box.
  [[nodiscard]] bool overlaps(const PixelBox& window) const;
  /// The octagon's extent in x over the rows [y_min, y_max]; false where it does not reach them.
  [[nodiscard]] bool span(double y_min, double y_max, double& x_min, double& x_max) const;
};

/// Contains every pixel centre the kernel covers at any time of its segment, at or beyond `near`. Where part
/// of the tube is nearer than `near`, the hull is clipped there, never projected through the eye. Returns
/// false if all of it is nearer.
[[nodiscard]] bool screen_bounds(const MovingKernel& kernel, const Projection& projection, double near,
                                 Octagon& octagon);

}  // namespace swept
