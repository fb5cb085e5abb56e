// Surfels: oriented elliptical Gaussian discs, as structure of arrays.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/point_array.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// Indices of three points, counter-clockwise as seen from the front.
using Triangle = std::array<std::uint32_t, 3>;

/// Colours beyond this either way are refused: sums and products of larger ones leave single precision.
inline constexpr float most_color = 1e30f;

/// Where the discs of a cloud are at one instant, in object space. The arrays may be views of the caller's
/// own (PointArray::view).
///
/// A disc is {c + u a₁ + v a₂ : u² + v² ≤ 1}; its kernel is exp(−δ(u² + v²)). So |a₁| and |a₂| are
/// radii at the kernel's cut-off, and a₁ × a₂ is the side that counts as front. The disc does not
/// change when (a₁, a₂) is rotated within its plane in (u, v).
struct SurfelPose {
  PointArray<Eigen::Vector3d> position;  ///< centres; double, so survey coordinates keep their digits
  PointArray<Eigen::Vector3f> axis_u;    ///< a₁, object-space units
  PointArray<Eigen::Vector3f> axis_v;    ///< a₂

  [[nodiscard]] std::size_t size() const { return position.size(); }
};

/// One instant of a keyed cloud. Times are in frames.
struct SurfelKey {
  double frame = 0.0;
  SurfelPose pose;
};

/// Points and how they move in object space. Every non-empty array has keys.front().pose.size()
/// entries.
struct SurfelCloud {
  /// One key: the points stand still, or follow `velocity` from that key's frame. Several, at
  /// strictly increasing frames and with equal counts: positions and axes are interpolated linearly
  /// between keys and held outside.
  std::vector<SurfelKey> keys;
  PointArray<Eigen::Vector3f> velocity;  ///< object units per frame; empty, or keys.size() == 1
  PointArray<Eigen::Vector3f> color;     ///< linear Rec.709, not premultiplied; empty: white
  PointArray<float> opacity;             ///< [0, 1]; empty: 1
  /// 1: a₁ × a₂ is known to point outside, so that the disc has a front and a back, which are two surfaces;
  /// 0: it may point either way. Empty: 0 for all.
  PointArray<std::uint8_t> oriented;

  [[nodiscard]] std::size_t size() const { return keys.empty() ? 0 : keys.front().pose.size(); }
  [[nodiscard]] bool is_oriented(std::size_t i) const { return !oriented.empty() && oriented[i] != 0; }
  [[nodiscard]] bool moves() const { return keys.size() > 1 || !velocity.empty(); }

  /// Counts agree, keys increase, every number is finite. The error's field names the array and the
  /// first offending index; its file is left for the caller to fill in.
  [[nodiscard]] Status validate() const;
};

/// Position and axes of point `i` at time `frame`, object space.
struct SurfelInstant {
  Eigen::Vector3d position;
  Eigen::Vector3d axis_u, axis_v;
};
[[nodiscard]] SurfelInstant surfel_at(const SurfelCloud& cloud, std::size_t i, double frame);

/// The same for many points of one cloud, which must outlive it: what does not depend on the point is found
/// once.
class SurfelsAt {
 public:
  SurfelsAt(const SurfelCloud& cloud, double frame);

  [[nodiscard]] SurfelInstant operator[](std::size_t i) const {
    SurfelInstant at{before_->position[i], before_->axis_u[i].cast<double>(),
                     before_->axis_v[i].cast<double>()};
    if (velocity_ != nullptr) at.position += elapsed_ * (*velocity_)[i].cast<double>();
    if (after_ == nullptr) return at;
    // a + t (b − a): a point equal in both keys stays there to the bit.
    at.position += t_ * (after_->position[i] - at.position);
    at.axis_u += t_ * (after_->axis_u[i].cast<double>() - at.axis_u);
    at.axis_v += t_ * (after_->axis_v[i].cast<double>() - at.axis_v);
    return at;
  }

 private:
  const SurfelPose* before_;
  const SurfelPose* after_ = nullptr;  ///< null: nothing is interpolated
  const PointArray<Eigen::Vector3f>* velocity_ = nullptr;
  double t_ = 0.0, elapsed_ = 0.0;
};

/// Axes of a round disc of the given radius facing `normal` (any length > 0), a₁ × a₂ along it.
void round_disc(const Eigen::Vector3d& normal, double radius, Eigen::Vector3f& axis_u,
                Eigen::Vector3f& axis_v);

/// Rotates each (axis_u, axis_v) of `moving` within its own plane, in place, to lie as near as it can
/// to that of `reference` (orthogonal Procrustes in (u, v), rotations only). The discs stay the same; what
/// changes is that interpolating between the two no longer turns or collapses them. Sizes must agree.
void align_axes(const SurfelPose& reference, SurfelPose& moving);

}  // namespace swept
