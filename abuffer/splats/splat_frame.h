// A frame of Gaussian splats: the mean of still images at instants of the exposure. Source: model section 14.
#pragma once

#include "abuffer/sampled.h"

namespace swept {

/// As render_sampled(), of a scene that is valid and passes check_splats(), with splats and perhaps discs.
/// Runs in the caller's task arena.
[[nodiscard]] Result<Rendered> render_splats(const Scene& scene, const SampledOptions& options,
                                             const RenderControl& control);

}  // namespace swept
