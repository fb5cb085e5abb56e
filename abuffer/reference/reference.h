// The reference: the plain average of many still images, slow and simple, by which the others are judged.
//
// Source: model sections 1 and 9. It shares no rasteriser, no sweep and no closed form with the exact
// renderer; what the two have in common is the list of moving kernels they are given.
#pragma once

#include "splat/export.h"
#include "splat/kernel/kernel_set.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// How the reference places the discs at an instant.
enum class ReferenceMotion {
  /// Along the linear segments of build_kernels(): the motion that the stochastic method and the GPU passes
  /// see, and the exact method if AbufferOptions::parabolas is false.
  segments,
  smooth,  ///< along the true path: curves, turning axes and the pixel filter are exact at every instant
};

struct ReferenceOptions {
  int samples = 256;  ///< N, still images averaged; even, [2, 2²⁰]
  ReferenceMotion motion = ReferenceMotion::smooth;

  [[nodiscard]] Status validate() const;
};

/// The mean of N still images at the midpoints (i + ½)/N of N strata of a box shutter, in double precision.
/// A closed shutter, or a scene in which nothing moves, takes one still image.
///
/// The image's own error is estimated from a second mean of N/2 still images at the midpoints of N/2 strata,
/// so a render costs 1.5 N of them. Where a pixel's signal jumps at an instant spread evenly over the
/// strata, the midpoint rule errs by a sawtooth of width h = 1/N: variance h²/12 with N, 4h²/12 with N/2,
/// correlation −1/4 between the two, and hence h²/2 for their difference, 6 times the variance sought.
/// Smoother signals have the ratio 9 or more. So the root mean square difference over √6 is the error of
/// the N-sample image where it jumps, and an upper estimate where it does not.
///
/// Statistics: "samples" is N, "instants" the still images rendered in all, "fragments" and "surfaces" those
/// of all these; "reference_error_rmse" is that estimate, on linear RGB, and "reference_error_psnr_db" the
/// same for peak 1 (+∞ where the error is 0). The counts of KernelSet are included; for smooth motion they
/// are those of the last instant. The stages overlap in one case: with smooth motion, "kernels" is part of
/// the other two.
///
/// A scene with Gaussian splats, whatever else is in it, is rendered by render_splat_reference(): along true
/// paths, with its statistics. control.max_bytes has no effect then.
///
/// Errors: options, control or scene out of range, not enough memory, and a render that was stopped.
/// control.max_bytes bounds the discs' kernels.
[[nodiscard]] Result<Rendered> render_reference(const Scene& scene, const ReferenceOptions& options,
                                                const RenderControl& control = {});

/// The same for given kernels: film, background and image model are the scene's, all else is the kernels'.
/// Always ReferenceMotion::segments.
[[nodiscard]] Result<Rendered> render_reference(const KernelSet& kernels, const Scene& scene,
                                                const ReferenceOptions& options,
                                                const RenderControl& control = {});

}  // namespace swept
