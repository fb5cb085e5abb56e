// The exact renderer of moving triangles: intervals of time at every place of every pixel. For the project's
// own sources. Source: model section 15.
#pragma once

#include "abuffer/abuffer.h"

namespace swept {

/// Of a scene of meshes alone, which is valid, through a pinhole. Runs in the caller's task arena. The result
/// is the same, bit for bit, for any thread count, tile size and order of the meshes, and a crop equals those
/// pixels of the whole frame.
[[nodiscard]] Result<Rendered> render_exact_meshes(const Scene& scene, const AbufferOptions& options,
                                                   const RenderControl& control);

}  // namespace swept
