// The time-sampled engine: the mean of still images at instants of the exposure, as many in each cell of the
// film as the error asked for takes. Source: model section 12.
#pragma once

#include "splat/export.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

struct SampledOptions {
  /// Instants in every cell in which something moves: the midpoints of so many strata of the exposure; [0,
  /// 2²⁰]. 0: as many as `max_error_db` takes, cell by cell.
  int samples = 0;
  /// PSNR that the frame is to reach, dB for peak 1; (0, 150]. It is met by an estimate, not by a bound.
  double max_error_db = 60.0;
  /// PSNR that every cell of 64 × 64 px is to reach, in addition; [0, 150]. 0: not asked for.
  double max_cell_error_db = 0.0;
  /// Wall-clock seconds to render for, in place of the errors above. Every cell gets its first instants,
  /// however long that takes; then cells are refined where that gains most, until the next step would end
  /// later. The image then depends on the machine. 0: not asked for.
  double max_seconds = 0.0;
  /// Adds the channel "error": the estimated root mean square error of each pixel over R, G and B. For a
  /// single pixel the estimate is random; it holds in the mean over a neighbourhood.
  bool error_channel = false;
  /// Leaves out every object that moves during the exposure, by itself or because the camera does.
  bool only_standing = false;
  /// Implementation of sampled_math.h to use, 0 being the plain loops that define the others; −1: the widest.
  /// Changes no bit.
  int implementation = -1;

  [[nodiscard]] Status validate() const;
};

/// Renders the scene's film window. At each instant points are where their true path has them; the scene's
/// segments are not used. The result is the same, bit for bit, for any thread count, instruction set and
/// order of the scene's points, and a crop equals those pixels of the whole frame. A cell in which nothing
/// moves takes a single instant.
///
/// Statistics: "instants" is the sum of the instants of all cells, "instants_per_pixel" their mean over the
/// film's window, and "most_instants" the most in any cell. Unless only `samples` is given, "expected_rmse",
/// "expected_psnr_db" (both of the window) and "expected_worst_cell_rmse" are estimated from alternating sums
/// of the instants. Rendered::parts are the cells.
///
/// A lens is looked through at as many points as the error takes, each at an instant of its own; "instants"
/// then counts these looks. If Aperture::samples or `samples` is given, every point of the lens is looked
/// through at instants of its own. Then the error is not estimated, and `max_seconds` and `error_channel` are
/// errors. "lens_points" is the number given, or the most of any cell.
///
/// Errors: options, control or scene out of range; `samples` together with `max_seconds`; a row delay
/// together with `max_seconds`, a lens, splats or triangles; not enough memory; a render that was stopped.
[[nodiscard]] Result<Rendered> render_sampled(const Scene& scene, const SampledOptions& options = {},
                                              const RenderControl& control = {});

}  // namespace swept
