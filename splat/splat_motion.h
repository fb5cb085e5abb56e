// How splats of a scene that was trained in motion move, turn and fade by themselves.
//
// Source: Li et al. 2024, Spacetime Gaussian Feature Splatting, the "lite" model. Time is that of training: 0
// is the first of the pictures, 1 is one picture beyond the last. With Δt = time − center a splat has
//   position + path₁ Δt + path₂ Δt² + path₃ Δt³,
//   rotation + Δt · turn, normalised,
//   opacity · exp(−(Δt / duration)²).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

struct SplatCloud;

/// The length of a clip, in frames, if nobody gives it: the number of pictures that the settings of
/// SpacetimeGaussians train on at once.
inline constexpr double usual_clip_frames = 50.0;

/// Every array has an entry for each splat of a cloud; the cloud has the splats at Δt = 0.
struct SplatMotion {
  std::vector<float> center;                         ///< training time
  std::vector<float> duration;                       ///< in training time, above 0
  std::vector<std::array<Eigen::Vector3f, 3>> path;  ///< object units per time, time² and time³
  std::vector<Eigen::Vector4f> turn;  ///< w x y z per time, added to the cloud's unit quaternion
  /// Frames from training time 0, which is SplatCloud::frame, to 1; above 0. Files do not say it.
  double frames = usual_clip_frames;

  /// Counts are the cloud's, every number is finite and in its range. The error's field names the array and
  /// the first offending index; its file is left for the caller to fill in.
  [[nodiscard]] Status validate(std::size_t splats) const;
};

/// The cloud at a training time, without velocities and motion. A rotation whose sum is zero is replaced by
/// the cloud's own. Precondition: motion.validate(cloud.size()).
[[nodiscard]] SplatCloud splats_at(const SplatCloud& cloud, const SplatMotion& motion, double time);

}  // namespace swept
