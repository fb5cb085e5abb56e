// The reference for Gaussian splats, by themselves or among discs and meshes: the plain mean of still images,
// in double precision, splat by splat and pixel by pixel. It shares nothing with the engine; discs and meshes
// are those of render_reference() along true paths.
//
// Sources: model section 14; Kerbl et al. 2023, 3D Gaussian Splatting (projection, blending, constants);
// Yu et al. 2023, Mip-Splatting (antialiased files); Huang et al. 2024, 2D Gaussian Splatting (discs).
#pragma once

#include "splat/export.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

struct SplatReferenceOptions {
  int samples = 256;  ///< N, still images averaged, [1, 2²⁰]
  int threads = 0;    ///< at most so many, [0, 1024]; 0: all there are. Changes no bit
};

/// The mean of N still images at the midpoints of N strata of the exposure, in linear light. A closed shutter
/// takes one. Splats at the same depth are in the order of the scene.
///
/// Statistics: "samples" N, "splats", and "fragments": places where a splat was blended into a pixel.
///
/// Of `control` stop, progress and log are looked at. Errors: options or scene out of range, rows exposed one
/// after the other, not enough memory, and a render that was stopped.
[[nodiscard]] Result<Rendered> render_splat_reference(const Scene& scene,
                                                      const SplatReferenceOptions& options,
                                                      const RenderControl& control = {});

}  // namespace swept
