// What of a scene is seen besides its colours: normals, motion vectors and coverage, for compositing.
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

/// Channels over the film's window, of the nearest surface at the middle of the exposure: the mean over its
/// discs, weighted by their kernels, or over what the places of the pixel meet first of a mesh. Not
/// premultiplied; 0 where there is none.
///
///   normal.x, .y, .z      unit, in world space, of the side that is seen
///   forward.u, .v         where the surface goes to on the film until the shutter closes, in px per frame: u
///   to
///                         the right, v up
///   backward.u, .v        where it came from since the shutter opened, likewise; opposed to forward where
///   motion
///                         is even
///   coverage              of the pixel by this surface, whatever its opacity, [0, 1]
///
/// While the shutter opens and closes at once the vectors are those of an instant: of points that move from
/// file to file, as far as the scene holds two of them. A point that is before the near plane at the other
/// end has no vectors: 0. A lens counts as a pinhole in its middle. The result does not depend on the number
/// of threads.
///
/// Errors: scene or control out of range, not enough memory, and a pass that was stopped.
[[nodiscard]] Result<std::vector<ImageChannel>> render_layers(const Scene& scene, const LayerChoice& choice,
                                                              const RenderControl& control = {});

}  // namespace swept
