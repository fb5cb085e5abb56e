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

/// Colours beyond ± this are refused: sums and products of larger ones leave the range of float.
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

/// How a cloud's path follows from its keys (model section 7). Before the first key and after the last the
/// cloud is held.
enum class KeyPath {
  linear,  ///< straight from key to key
  /// A cubic through the keys, in position and axes. Its velocity at a key is that of the parabola through it
  /// and its neighbours; at the first and the last key, of the parabola through the three keys at that end.
  spline,
  /// The poses are the control points of one Bézier curve of degree keys.size() − 1, from the first key's
  /// frame to the last's. The frames between only order them.
  bezier,
};

/// Colours and opacities of a cloud at one instant, as SurfelCloud has them. Times are in frames.
struct LookKey {
  double frame = 0.0;
  PointArray<Eigen::Vector3f> color;  ///< empty: white
  PointArray<float> opacity;          ///< empty: 1
};

/// When a point exists: in [born, gone), absolute frames.
struct Lifetime {
  double born, gone;
};

/// Points and how they move in object space. Every non-empty array has keys.front().pose.size()
/// entries.
struct SurfelCloud {
  /// One key: the points stand still, or follow the motion below from that key's frame. Several, at
  /// strictly increasing frames and with equal counts: `path` says what lies between them.
  std::vector<SurfelKey> keys;
  KeyPath path = KeyPath::linear;
  PointArray<Eigen::Vector3f> velocity;      ///< object units per frame; empty, or keys.size() == 1
  PointArray<Eigen::Vector3f> acceleration;  ///< object units per frame²; likewise
  /// Radians per frame about the disc's own centre, right-handed, the axis in object space; likewise.
  PointArray<Eigen::Vector3f> angular_velocity;
  std::vector<Lifetime> lifetime;     ///< empty: all points exist at any time
  PointArray<Eigen::Vector3f> color;  ///< linear Rec.709, not premultiplied; empty: white
  PointArray<float> opacity;          ///< [0, 1]; empty: 1
  /// Colours and opacities that change; if there are any, they replace `color` and `opacity`. Between two
  /// keys opacity, and colour times opacity, are linear in time. Before the first key and after the last they
  /// are held. Frames increase; they need not be those of `keys`.
  std::vector<LookKey> looks;
  /// 1: a₁ × a₂ is known to point outside, so that the disc's front and back are two surfaces. 0: it may
  /// point either way. Empty: 0 for all.
  PointArray<std::uint8_t> oriented;

  [[nodiscard]] std::size_t size() const { return keys.empty() ? 0 : keys.front().pose.size(); }
  [[nodiscard]] bool is_oriented(std::size_t i) const { return !oriented.empty() && oriented[i] != 0; }
  /// Whether anything but looks changes over time; rates that are all zero do not count. This and the next
  /// two functions take time linear in the points.
  [[nodiscard]] bool moves() const;
  [[nodiscard]] bool accelerates() const;
  [[nodiscard]] bool spins() const;
  /// Whether any point lets light through at any time.
  [[nodiscard]] bool see_through() const;
  /// Whether paths may bend between keys, or discs turn without being keyed.
  [[nodiscard]] bool curved() const {
    return (keys.size() > 2 && path != KeyPath::linear) || accelerates() || spins();
  }
  [[nodiscard]] bool exists(std::size_t i, double frame) const {
    return lifetime.empty() || (lifetime[i].born <= frame && frame < lifetime[i].gone);
  }

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

/// A time on the paths of a cloud, as the weights of what the cloud holds; they are the same for all points.
struct PathWeights {
  struct Share {
    std::size_t key;
    double weight;
  };
  std::size_t base = 0;                       ///< key from which the others are measured
  std::vector<Share> others;                  ///< base + Σ weight (key − base), for positions and axes
  double velocity = 0.0, acceleration = 0.0;  ///< their factors in the position: frames and frames²
  double elapsed = 0.0;                       ///< frames for which discs have turned
};

/// Positions and axes of many points of one cloud at one time; what does not depend on the point is computed
/// once. The cloud must outlive it.
class SurfelsAt {
 public:
  SurfelsAt(const SurfelCloud& cloud, double frame);
  SurfelsAt(const SurfelCloud& cloud, PathWeights weights);

  [[nodiscard]] SurfelInstant operator[](std::size_t i) const {
    SurfelInstant at{position(i), base_->axis_u[i].cast<double>(), base_->axis_v[i].cast<double>()};
    if (!weights_.others.empty()) add_other_axes(i, at);
    if (spin_ != nullptr) turn((*spin_)[i], at);
    return at;
  }
  /// The same, without what axes cost.
  [[nodiscard]] Eigen::Vector3d position(std::size_t i) const {
    Eigen::Vector3d at = base_->position[i];
    if (velocity_ != nullptr) at += weights_.velocity * (*velocity_)[i].cast<double>();
    if (acceleration_ != nullptr) at += weights_.acceleration * (*acceleration_)[i].cast<double>();
    if (weights_.others.empty()) return at;
    // a + t (b − a): a point equal in all keys stays there to the bit.
    const Eigen::Vector3d from = at;
    for (const PathWeights::Share& other : weights_.others)
      at += other.weight * (keys_[other.key].pose.position[i] - from);
    return at;
  }

 private:
  void add_other_axes(std::size_t i, SurfelInstant& at) const {
    const Eigen::Vector3d from_u = at.axis_u, from_v = at.axis_v;
    for (const PathWeights::Share& other : weights_.others) {
      const SurfelPose& pose = keys_[other.key].pose;
      at.axis_u += other.weight * (pose.axis_u[i].cast<double>() - from_u);
      at.axis_v += other.weight * (pose.axis_v[i].cast<double>() - from_v);
    }
  }
  void turn(const Eigen::Vector3f& rate, SurfelInstant& at) const;

  const SurfelKey* keys_;
  const SurfelPose* base_;
  const PointArray<Eigen::Vector3f>*velocity_ = nullptr, *acceleration_ = nullptr, *spin_ = nullptr;
  PathWeights weights_;
};

/// Shifts the path of every point in time, so that it is at its key's pose at stamps[i], an absolute frame,
/// instead of at the key's frame. The cloud has one key, with or without rates. Errors: several keys, a wrong
/// count, stamps that are not finite, paths that leave the range of float.
[[nodiscard]] Status shift_to_stamps(SurfelCloud& cloud, const std::vector<double>& stamps);
/// Axes of a round disc of the given radius, with a₁ × a₂ along `normal` (of any length > 0).
void round_disc(const Eigen::Vector3d& normal, double radius, Eigen::Vector3f& axis_u,
                Eigen::Vector3f& axis_v);

/// Rotates each (axis_u, axis_v) of `moving` within its own plane, in place, to lie as near as it can
/// to that of `reference` (orthogonal Procrustes in (u, v), rotations only). The discs stay the same; what
/// changes is that interpolating between the two no longer turns or collapses them. Sizes must agree.
void align_axes(const SurfelPose& reference, SurfelPose& moving);

}  // namespace swept
