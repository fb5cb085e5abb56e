// A frame of Gaussian splats, triangles and discs in one: the mean of still images at instants of the
// exposure. Source: model sections 14 and 15.
#pragma once

#include "abuffer/sampled.h"

namespace swept {

/// As render_sampled(), of a scene that is valid and passes check_splats(), with splats or triangles, and
/// perhaps discs. Runs in the caller's task arena.
[[nodiscard]] Result<Rendered> render_splats(const Scene& scene, const SampledOptions& options,
                                             const RenderControl& control);

}  // namespace swept
