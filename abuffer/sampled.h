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
  /// Instants in every cell in which something moves, at the midpoints of so many strata of the exposure; [1,
  /// 2²⁰]. 0: as many as `max_error_db` takes, cell by cell.
  int samples = 0;
  /// PSNR that the frame is to reach, dB for peak 1; (0, 150]. Met as far as the estimate sees.
  double max_error_db = 60.0;
  /// The same for every cell of 64 × 64 px by itself, besides; 0: not asked for. [0, 150]
  double max_cell_error_db = 0.0;
  /// Seconds to render for, wall-clock, in place of the errors above: cells are refined where that gains most
  /// until the next step would end later. Every cell has its first instants, however long that takes. 0: not
  /// asked for. The image depends on the machine then.
  double max_seconds = 0.0;
  /// Adds the channel "error": the expected root mean square error of each pixel over R, G and B. It is a
  /// draw for a pixel by itself, an expectation over a neighbourhood.
  bool error_channel = false;
  /// Leaves out every object that moves during the exposure, by itself or because the camera does.
  bool only_standing = false;
  /// Implementation of sampled_math.h to use, 0 being the plain loops that define the others; −1: the widest.
  /// Changes no bit.
  int implementation = -1;

  [[nodiscard]] Status validate() const;
};

/// Renders the scene's film window: points are where their true path has them at each instant, and the
/// scene's segments are not used. The result is the same, bit for bit, for any thread count and order of the
/// scene's points, for every instruction set, and a crop equals those pixels of the whole frame. What does
/// not move takes a single instant.
///
/// Statistics: "instants" cells × instants, "instants_per_pixel" their mean over the film's window,
/// "most_instants" in any cell, and unless `samples` alone is given "expected_rmse" and "expected_psnr_db" of
/// the window, estimated from alternating sums of the instants, and "expected_worst_cell_rmse".
/// Rendered::parts are the cells.
///
/// A lens is looked through from as many points as the error takes, each at an instant of its own, and
/// "instants" are these looks. Of a lens whose points are given (Aperture::samples), and with `samples`, all
/// points are looked through at instants of their own: the error is not estimated then, and neither
/// `max_seconds` nor `error_channel` can be had. "lens_points" are those given, or the most of any cell.
///
/// Errors: options, control or scene out of range, not enough memory, and a render that was stopped.
[[nodiscard]] Result<Rendered> render_sampled(const Scene& scene, const SampledOptions& options = {},
                                              const RenderControl& control = {});

}  // namespace swept
