// The moving kernel: an elliptical Gaussian disc in linear motion, filtered for the pixel grid.
//
// Source: model sections 2, 3, 5 and 6; Heinzle et al. 2010, sections 4.1 to 4.3. Heinzle transforms the
// viewing ray by the inverse of [a₁ a₂ m c], which is singular for every motion within the disc's
// plane. Here a ray meets the moving plane instead, and nothing is inverted:
//
//   u = d·(a₂ × c) / d·n,   v = d·(c × a₁) / d·n,   z = n·c / d·n,   n = a₁ × a₂,   d = (dx, dy, 1)
//
// With c(τ) = c + (τ − τ_mid) m all three are linear in τ, for any m.
#pragma once

#include <cstdint>

#include <algorithm>

#include <Eigen/Core>

#include "splat/export.h"

namespace SWEPT_API swept {

/// The pixel filter in camera space, and the part of the camera where it is to be accurate.
struct PixelFilter {
  double radius = 0.0;         ///< at the kernel's cut-off, as a tangent: filter_radius_px / focal_px
  double max_tangent_x = 1.0;  ///< |x/z| and |y/z| beyond which the filter is that of the frame's border
  double max_tangent_y = 1.0;
  double near = 1e-3;         ///< depth below which the filter stops shrinking
  bool orthographic = false;  ///< then the radius is a length, the same at any depth, and tangents are 0
};

/// A disc whose plain projection is the given disc's projection convolved with the pixel filter.
///
/// To first order a disc with axes A = [a₁ a₂] projects to an ellipse with covariance QQᵀ, Q = PA,
/// P = [I₂ | −c_xy/c_z] in the plane z = c_z. The convolution adds r²I (Heckbert 1989, Zwicker 2002). The
/// result is lifted back into space on the plane through c with slope g = (A_z Qᵀ) (QQᵀ + r²I)⁻¹, the
/// regression of the disc's depth on its filtered projection. That is the disc's own plane where the disc is
/// large on screen, a plane facing the screen where it is small or edge-on, and analytic between: the
/// change of form that model section 5 asks for needs no switch. Depths stay within the disc's own.
struct FilteredDisc {
  Eigen::Vector3d axis_u, axis_v;  ///< camera space; parallel only if radius == 0 and the disc is degenerate
  double weight =
      0.0;  ///< peak of the convolved kernel, √(|QQᵀ| / |QQᵀ + r²I|) ∈ [0, 1]; 0: degenerate or edge-on
  /// The unit of the depth tolerance: root mean square radius of the filtered disc laid on the disc's own
  /// plane, where its neighbours on the surface are. Slopes that the filter hides (s < r/4) count as the
  /// steepest it shows.
  double size = 0.0;
};

/// `center`, `axis_u`, `axis_v` in camera space, finite. A filter of radius 0 returns the disc itself with
/// weight 1 (weight 0 if its axes are parallel).
[[nodiscard]] FilteredDisc filter_disc(const Eigen::Vector3d& center, const Eigen::Vector3d& axis_u,
                                       const Eigen::Vector3d& axis_v, const PixelFilter& filter);

/// One segment of one surfel, in camera space and filtered; linear in τ, unless `bend` is set. τ is
/// shutter time, in [0, 1].
struct MovingKernel {
  Eigen::Vector3d center;          ///< at τ = t_mid()
  Eigen::Vector3d velocity;        ///< m, per unit of τ; exactly zero: a still kernel
  Eigen::Vector3f axis_u, axis_v;  ///< filtered disc, fixed over the segment
  Eigen::Vector3f facing;          ///< visible where facing·d < 0; zero: from both sides
  /// The disc's normal on its outside: a ray sees the front where outside·d < 0, which holds for the whole
  /// segment. Zero: not known.
  Eigen::Vector3f outside = Eigen::Vector3f::Zero();
  float t_begin = 0.0f, t_end = 1.0f;  ///< shutter time
  float weight = 1.0f;                 ///< of the filtered disc
  float depth_tolerance = 0.0f;        ///< ε, camera-space units; at t_mid()
  Eigen::Vector4f color;               ///< at t_mid(): linear, premultiplied by opacity; w is the opacity
  Eigen::Vector4f color_rate = Eigen::Vector4f::Zero();  ///< per unit of τ
  /// Half of the acceleration: with s = τ − t_mid() and h = half_time() the disc is at center + s·velocity +
  /// (s² − h²/3)·bend, whose mean over the segment is `center`. Zero: straight. See bent_kernel.h.
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
  /// Change of ε per unit of τ: discs that come nearer are seen through a smaller filter. 0 if ε changes by
  /// little.
  float tolerance_rate = 0.0f;

  [[nodiscard]] float t_mid() const { return 0.5f * (t_begin + t_end); }
  /// Whether the kernel stays in place; its colour may change.
  [[nodiscard]] bool still() const { return velocity.isZero(0.0); }
  /// Whether it is the same at all times of the exposure.
  [[nodiscard]] bool stays() const { return still() && !changes_color() && t_begin == 0.0f && t_end == 1.0f; }
  [[nodiscard]] bool changes_color() const { return !color_rate.isZero(0.0f); }
  [[nodiscard]] bool bent() const { return !bend.isZero(0.0); }
  [[nodiscard]] double half_time() const {
    return 0.5 * (static_cast<double>(t_end) - static_cast<double>(t_begin));
  }

  /// Makes a kernel that of a part of its segment, after its times were set to those of the part: the part's
  /// middle is `later` than the segment's was, and the segment's half_time() was `half_before`.
  void keep_part(double later, double half_before) {
    center += later * velocity;
    if (tolerance_rate != 0.0f)
      depth_tolerance = std::max(0.0f, depth_tolerance + static_cast<float>(later) * tolerance_rate);
    if (!bent()) return;
    center += (later * later + (half_time() * half_time() - half_before * half_before) / 3.0) * bend;
    velocity += 2.0 * later * bend;
  }
};

}  // namespace swept
