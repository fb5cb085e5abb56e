// The sampled methods that analytical ones are judged against: random points of pixel, lens and time, each of
// which sees what is there at its instant. Source: Gribel et al. 2013, section 4; model section 18.
#pragma once

#include "splat/export.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// How to find the samples that a moving primitive may cover (Gribel et al. 2013, section 4).
enum class Traversal {
  automatic,   ///< `tile` or `interval`: the faster one by a forecast from some of the primitives
  tile,        ///< per tile of the film, the time in which the primitive may overlap it
  interval,    ///< per part of the exposure, the box of the film in which the primitive stays
  interleave,  ///< samples share a fixed number of times, and each of these is rasterised by itself
  hierarchy    ///< moving boxes (US 8791945): per tile a time, and rays from the lowest node that holds all
               ///< that the tile may see
};

/// Whether this build has the hierarchy of moving boxes (SWEPT_HIERARCHY).
[[nodiscard]] bool hierarchy_available();

/// What encloses Bézier curves in tile tests: subdividable linear efficient function enclosures (Lutterkort
/// and Peters 1999), or the convex hulls of control points.
enum class CurveBounds { slefes, hulls };

/// Only `samples` and `times` change the image.
struct StochasticOptions {
  int samples = 128;  ///< per pixel; [1, 2¹⁶]
  /// Instants that all samples share, evenly spaced in shutter time; [0, 65536]. 0: every sample has an
  /// instant of its own; the traversal `interleave` takes 256 shared ones.
  int times = 0;
  Traversal traversal = Traversal::automatic;
  int tile_px = 4;     ///< side of a tile; 1, 2, 4, 8 or 16
  int intervals = 16;  ///< parts of the exposure; [1, 1024]
  CurveBounds bounds = CurveBounds::slefes;

  [[nodiscard]] Status validate() const;
};

/// Renders the scene's film window with motion and defocus at once. Samples depend only on the pixel's place
/// on the film. So the image is the same, bit for bit, for any thread count, traversal and order of the
/// scene's points, and a crop equals those pixels of the whole frame.
///
/// A sample meets triangles at its own place in the pixel. Their corners move along pieces of parabolas, as
/// many as keep them within 0.01 px of the true path. A sample meets discs through the pixel's centre,
/// because the pixel filter is theirs. Discs move along the segments of build_kernels(), and are composited
/// as in a still image (model section 1). The expectation is the image of the model, except that
/// - through a lens a disc keeps the filter that it has for the middle of the lens;
/// - where a triangle's edge lies over another object within a pixel, what is behind shows where the edge
///   leaves it free, while the model mixes the pixel's means (section 15.3);
/// - a sample may be anywhere in the pixel, while the model has 16 places in it.
///
/// Looks that change, and textures, are those of the place and the instant at which a sample meets a
/// triangle; looks of discs are those of the instant.
///
/// Statistics: "samples" per pixel; "samples_tested", "samples_inside" and their ratio
/// "sample_test_efficiency"; "bounds_tested" (tiles or boxes); "primitives" that may be seen;
/// "primitive_bytes"; if the traversal is automatic, "forecast_tile_us" and "forecast_interval_us" per
/// primitive. The effects name the traversal.
///
/// Errors: options, control or scene out of range; splats and row delays, which are refused by name; not
/// enough memory; a render that was stopped. control.max_bytes bounds kernels and paths.
[[nodiscard]] Result<Rendered> render_stochastic(const Scene& scene, const StochasticOptions& options = {},
                                                 const RenderControl& control = {});

}  // namespace swept
