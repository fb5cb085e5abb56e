// The pixel filter of a scene's film. Private to splat.
#pragma once

#include "splat/kernel/moving_kernel.h"
#include "splat/scene.h"

namespace swept {

[[nodiscard]] inline PixelFilter filter_of(const Scene& scene, const Projection& projection) {
  // A guard band: beyond it a disc touches the frame with its rim only, if at all.
  constexpr double guard = 1.3;
  return {scene.model.filter_radius_px / projection.focal_px,
          guard * largest_tangent(scene.film, projection, 0),
          guard * largest_tangent(scene.film, projection, 1), scene.camera.near, projection.orthographic};
}

}  // namespace swept
