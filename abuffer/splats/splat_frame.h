// A frame of Gaussian splats: the mean of still images at instants of the exposure. Source: model section 13.
#pragma once

#include "abuffer/sampled.h"

namespace swept {

/// Whether render_splats() draws a scene that has splats.
[[nodiscard]] Status check_splats(const Scene& scene);

/// As render_sampled(), of a scene that is valid and passes check_splats(). Runs in the caller's task
/// arena.
[[nodiscard]] Result<Rendered> render_splats(const Scene& scene, const SampledOptions& options,
                                             const RenderControl& control);

}  // namespace swept
