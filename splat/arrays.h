// Clouds from a caller's own arrays. What lies in memory as the renderers read it is not copied.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/result.h"
#include "splat/splat_cloud.h"
#include "splat/strided.h"
#include "splat/surfel.h"

namespace SWEPT_API swept {

/// Colours and opacities of discs at one time, for discs whose looks change: LookKey.
struct LookArrays {
  double frame = 0.0;
  Strided<Eigen::Vector3f> color;  ///< viewed; none: white
  Strided<float> opacity;          ///< viewed; none: 1
};

/// Discs in arrays of the caller. An empty array counts as not given; the others have an entry per point.
///
/// An array marked "viewed" is not copied, whatever its stride, if its first entry has the alignment of its
/// type and the stride keeps that. The cloud reads it where it lies, so it must stay there and unchanged
/// until the cloud and its copies are gone. The other arrays are converted into arrays of the cloud's own.
struct SurfelArrays {
  Strided<Eigen::Vector3d> position;             ///< viewed; this or position_single
  Strided<Eigen::Vector3f> position_single;      ///< positions in single precision
  Strided<Eigen::Vector3f> axis_u, axis_v;       ///< viewed; as SurfelPose: both, or normal and radius
  Strided<Eigen::Vector3f> normal;               ///< of any length but 0
  Strided<float> radius;                         ///< at the kernel's cut-off, object units; one entry: of all
  Strided<Eigen::Vector3f> velocity_per_frame;   ///< viewed; object units per frame
  Strided<Eigen::Vector3f> velocity_per_second;  ///< or per second, with `frames_per_second`
  double frames_per_second = 24.0;
  double frame = 0.0;              ///< the frame at which points are at their positions
  Strided<Eigen::Vector3f> color;  ///< viewed; linear Rec.709; none: white
  Strided<float> opacity;          ///< viewed; [0, 1]; none: 1
  /// For points whose looks change during the exposure, in place of `color` and `opacity`:
  /// SurfelCloud::looks.
  std::vector<LookArrays> looks;
  /// Whether a₁ × a₂, or the normal, is known to point outside, for all points: SurfelCloud::oriented.
  bool oriented = false;
};

/// Gaussian splats in arrays of the caller; "viewed" as above. SplatCloud says what they mean.
struct SplatArrays {
  Strided<Eigen::Vector3d> position;  ///< viewed; this or position_single
  Strided<Eigen::Vector3f> position_single;
  Strided<Eigen::Vector3f> scale;          ///< viewed; standard deviations, ≥ 0
  Strided<Eigen::Vector4f> rotation_wxyz;  ///< of any length but 0
  Strided<float> opacity;                  ///< viewed; [0, 1]
  int degree = 0;
  Strided<float> harmonics;                     ///< viewed if packed; as SplatCloud::harmonics
  Strided<Eigen::Vector3f> velocity_per_frame;  ///< viewed
  Strided<Eigen::Vector3f> velocity_per_second;
  double frames_per_second = 24.0;
  double frame = 0.0;
  SplatFilter filter = SplatFilter::dilated;
  SplatColors colors = SplatColors::srgb;
};

/// Errors: arrays that are missing, given twice or of different lengths, numbers that are not finite or out
/// of range, not enough memory. The field is the array's name, with an index where one entry is at fault.
[[nodiscard]] Result<SurfelCloud> cloud_from_arrays(const SurfelArrays& arrays) noexcept;
[[nodiscard]] Result<SplatCloud> splats_from_arrays(const SplatArrays& arrays) noexcept;

}  // namespace swept
