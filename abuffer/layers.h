// What compositing needs besides colours: normals, motion vectors and coverage.
#pragma once

#include <vector>

#include "splat/export.h"
#include "splat/image.h"
#include "splat/render_control.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

struct LayerChoice {
  bool normal = false, motion = false, coverage = false;

  [[nodiscard]] bool any() const { return normal || motion || coverage; }
};

/// Channels of the nearest surface at the middle of the exposure, over the film's window, row by row as in
/// Image. They are means over the discs of that surface, weighted by their kernels, or over the first
/// triangles of a mesh that the places of the pixel meet. Not premultiplied; 0 where there is no surface.
///
///   normal.x, .y, .z      unit vector in world space, of the side that is seen
///   forward.u, .v         displacement on the film until the shutter closes, px per frame: u to the
///                         right, v up
///   backward.u, .v        displacement on the film back to when the shutter opened, likewise; for even
///                         motion the negative of forward
///   coverage              share of the pixel that this surface covers, whatever its opacity, [0, 1]
///
/// If the shutter opens and closes at once, the vectors are those of the instant; points that move from file
/// to file have vectors then if the scene holds two of the files. A point that is nearer than the near plane
/// at the other end of the exposure has no vector: 0. A lens counts as a pinhole in its middle. The result
/// does not depend on the number of threads.
///
/// Errors: scene or control out of range, not enough memory, and a pass that was stopped.
[[nodiscard]] Result<std::vector<ImageChannel>> render_layers(const Scene& scene, const LayerChoice& choice,
                                                              const RenderControl& control = {});

}  // namespace swept
