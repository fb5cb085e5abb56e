// The exact renderer of moving triangles: intervals of time at every place of every pixel. For the project's
// own sources. Source: model section 15.
#pragma once

#include <vector>

#include "abuffer/abuffer.h"
#include "abuffer/visibility.h"

namespace swept {

/// What a render is asked besides: which triangle each place of each pixel sees at these times, which are in
/// [0, 1), by shutter time, and rise. Triangles as in VisibleTriangles.
struct MeshProbe {
  std::vector<double> times;
  std::vector<std::uint32_t> triangles;
};

/// Of a scene of meshes alone, which is valid, through a pinhole. Runs in the caller's task arena. The result
/// is the same, bit for bit, for any thread count, tile size and order of the meshes, and a crop equals those
/// pixels of the whole frame.
[[nodiscard]] Result<Rendered> render_exact_meshes(const Scene& scene, const AbufferOptions& options,
                                                   const RenderControl& control, MeshProbe* probe = nullptr);

}  // namespace swept
