// The sampled methods that analytical ones are judged against: points in pixel, lens and time, each met by
// what is there at its instant. Source: Gribel et al. 2013, section 4; model section 18.
#pragma once

#include "splat/export.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// How the samples are found that a moving primitive may cover (Gribel et al. 2013, section 4).
enum class Traversal {
  automatic,   ///< `tile` or `interval`, whichever a forecast from some of the primitives has as the faster
  tile,        ///< per tile of the film, the time in which the primitive may overlap it
  interval,    ///< per part of the exposure, the box of the film in which the primitive stays
  interleave,  ///< samples share a fixed number of times, and each of these is rasterised by itself
  hierarchy    ///< of moving boxes (US 8791945): per tile a time, and rays from the node that has all it may
               ///< see
};

/// Whether this build has the hierarchy of moving boxes (SWEPT_HIERARCHY).
[[nodiscard]] bool hierarchy_available();

/// What encloses Bézier curves in tile tests: subdividable linear efficient function enclosures (Lutterkort
/// and Peters 1999), or the convex hulls of control points.
enum class CurveBounds { slefes, hulls };

/// None of these changes a bit of the image but `samples` and `times`.
struct StochasticOptions {
  int samples = 128;  ///< per pixel; [1, 2¹⁶]
  /// Instants that all samples share, evenly spaced in shutter time; [0, 65536]. 0: every sample has an
  /// instant of its own, but where the traversal is `interleave`, which takes 256 then.
  int times = 0;
  Traversal traversal = Traversal::automatic;
  int tile_px = 4;     ///< side of a tile; 1, 2, 4, 8 or 16
  int intervals = 16;  ///< parts of the exposure; [1, 1024]
  CurveBounds bounds = CurveBounds::slefes;

  [[nodiscard]] Status validate() const;
};

/// Renders the scene's film window: motion and defocus at once. Samples depend on the pixel's place on the
/// film alone, so that the image is the same, bit for bit, for any thread count, traversal and order of the
/// scene's points, and a crop equals those pixels of the whole frame.
///
/// Triangles are met where the sample is in the pixel. Their corners move along pieces of parabolas, as many
/// as keep them within 0.01 px of the true path. Discs are met through the pixel's centre, for the pixel
/// filter is theirs, and composed as a still image is (model section 1), along the segments of
/// build_kernels(). The expectation is the image of the model, but for this:
/// - Through a lens a disc keeps the filter that it has for the middle of the lens.
/// - Where a triangle's edge lies over another object within a pixel, what is behind shows where the edge
///   leaves it free; the model mixes the pixel's means (section 15.3).
/// - A pixel is looked at everywhere; the model has 16 places in it.
///
/// Statistics: "samples" per pixel, "samples_tested", "samples_inside", their ratio
/// "sample_test_efficiency", "bounds_tested" (tiles or boxes), "primitives" that may be seen,
/// "primitive_bytes"; "forecast_tile_us" and "forecast_interval_us" a primitive, where the traversal was
/// chosen by them. Which one it is, is among the effects.
///
/// Textures and looks that change are those of the place and the instant at which a sample meets a triangle,
/// and looks of discs those of the instant.
///
/// Errors: options, control or scene out of range, splats and row delays, which are refused by name, not
/// enough memory, and a render that was stopped. control.max_bytes bounds kernels and paths.
[[nodiscard]] Result<Rendered> render_stochastic(const Scene& scene, const StochasticOptions& options = {},
                                                 const RenderControl& control = {});

}  // namespace swept
