// Gaussian splats as they are trained: ellipsoids of density with colours that depend on the view.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "splat/export.h"
#include "splat/point_array.h"
#include "splat/result.h"
#include "splat/splat_motion.h"

namespace SWEPT_API swept {

/// How a trained file says that its splats are to be drawn. Source: Kerbl et al. 2023 and Yu et al. 2023.
enum class SplatFilter {
  dilated,      ///< the covariance grows by the film's dilation, the opacity stays
  antialiased,  ///< in addition the opacity is scaled, by √(determinant before / after dilation)
};

/// The values in which the splats of a file are blended: sRGB or linear light.
enum class SplatColors { srgb, linear };

/// Splats in object space, as structure of arrays. Axes are those of the file. Every non-empty array has
/// position.size() entries; `harmonics` has that many times coefficients(degree) · 3.
struct SplatCloud {
  PointArray<Eigen::Vector3d> position;  ///< means
  PointArray<Eigen::Vector3f> scale;     ///< standard deviations along the rotated axes, object units, ≥ 0
  PointArray<Eigen::Quaternionf> rotation;  ///< object from splat axes, unit length
  PointArray<float> opacity;                ///< at the mean, [0, 1]
  int degree = 0;                           ///< of the spherical harmonics, 0 to 3
  /// Splat by splat, coefficient by coefficient (degree 0 first, then each degree's orders −l … l), red green
  /// blue. The colour is max(0, ½ + Σ coefficient · basis(direction from eye to splat)), in `colors` values.
  PointArray<float> harmonics;
  PointArray<Eigen::Vector3f> velocity;  ///< object units per frame; empty: the splats stand still
  /// With velocities, the frame at which positions hold; with `motion`, the frame of training time 0.
  double frame = 0.0;
  /// The trained motion of splats that move, turn and fade by themselves; these have no velocities.
  std::optional<SplatMotion> motion;
  bool flat = false;  ///< 2D splats: scale z is 0 and a ray meets the disc (Huang et al. 2024)
  SplatFilter filter = SplatFilter::dilated;
  SplatColors colors = SplatColors::srgb;

  [[nodiscard]] std::size_t size() const { return position.size(); }
  /// Whether splats may change while their object stands still.
  [[nodiscard]] bool moves() const { return !velocity.empty() || motion.has_value(); }
  [[nodiscard]] Eigen::Vector3d position_at(std::size_t splat, double at_frame) const;
  [[nodiscard]] static constexpr int coefficients(int degree) { return (degree + 1) * (degree + 1); }

  /// Counts agree, every number is finite and in its range. The error's field names the array and the first
  /// offending index; its file is left for the caller to fill in.
  [[nodiscard]] Status validate() const;
};

}  // namespace swept
