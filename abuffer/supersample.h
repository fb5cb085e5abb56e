// Temporal supersampling: the mean of N still images, as renderers without motion blur are used. The
// baseline that the exact renderer has to beat, given the same fast still path.
#pragma once

#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

struct SupersampleOptions {
  int samples = 16;  ///< N, still images averaged; [1, 2²⁰]
  int threads = 0;   ///< [0, 1024]; 0: as many as the machine has. Changes no bit

  [[nodiscard]] Status validate() const;
};

/// The mean of N still images at the midpoints (i + ½)/N of N strata of the shutter, each by
/// render_abuffer(); one where the shutter is closed or nothing moves. Points are where the true path has
/// them at each instant; the scene's segments are not used.
///
/// Statistics: "samples" N, "instants" still images rendered, "fragments" of all of them.
///
/// Errors: options or scene out of range, and not enough memory.
[[nodiscard]] Result<Rendered> render_supersampled(const Scene& scene,
                                                   const SupersampleOptions& options = {});

}  // namespace swept
