// A mesh's corners over the exposure as Bézier curves of degree one or two, piece by piece, in the space of
// the projection at mid-shutter. Source: Gribel et al. 2013, section 3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

#include "splat/camera.h"
#include "splat/scene.h"

namespace swept::stochastic {

/// How far a curve may be from the true path, px, on the film and far beside it: where corners have at most
/// this tangent to the axis, 84°. Farther out the angle counts, not where a longer film would show it:
/// corners that pass by the eye's own plane would take pieces without end there.
inline constexpr double path_tolerance_px = 0.01, path_tangent = 10.0;

class MeshPaths {
 public:
  /// The pieces are the stretches of MovingMesh::follow(), which says what cannot be followed; lines and
  /// parabolas are cut at keys alone. `object` has triangles. Throws Stopped.
  [[nodiscard]] static Result<MeshPaths> follow(const Scene& scene, const Object& object,
                                                const Exposure& exposure, const std::stop_token& stop);

  [[nodiscard]] const Object& object() const { return *object_; }
  /// The frame at a time in [0, 1].
  [[nodiscard]] double frame(double time) const { return open_ + time * (close_ - open_); }
  /// Whether all of its texture, if there is one, and of looks that change lets no light through.
  [[nodiscard]] bool opaque_looks() const { return opaque_looks_; }
  [[nodiscard]] bool mirrored() const { return mirrored_; }
  /// 1 where every corner moves evenly along a line in every piece, else 2.
  [[nodiscard]] int degree() const { return degree_; }
  [[nodiscard]] int pieces() const { return static_cast<int>(cuts_.size()) - 1; }
  [[nodiscard]] std::size_t bytes() const { return controls_.size() * sizeof(Eigen::Vector3d); }
  /// Times, from 0 where the shutter opens to 1: piece p lies between cuts p and p + 1.
  [[nodiscard]] double cut(int i) const { return cuts_[static_cast<std::size_t>(i)]; }
  /// The piece that a time in [0, 1] belongs to.
  [[nodiscard]] int piece_of(double time) const {
    int piece = 0;
    while (piece + 1 < pieces() && time >= cuts_[static_cast<std::size_t>(piece) + 1]) ++piece;
    return piece;
  }
  /// The three control points of degree 2 of a point in a piece, whatever degree() is.
  [[nodiscard]] const Eigen::Vector3d* controls(std::uint32_t point, int piece) const {
    return &controls_[point * stride_ + 2 * static_cast<std::size_t>(piece)];
  }
  /// The Bernstein polynomials of degree 2.
  using Weights = std::array<double, 3>;
  [[nodiscard]] Weights weights(int piece, double time) const {
    const double t = (time - cut(piece)) / (cut(piece + 1) - cut(piece)), s = 1.0 - t;
    return {s * s, 2.0 * s * t, t * t};
  }
  [[nodiscard]] Eigen::Vector3d at(std::uint32_t point, int piece, const Weights& w) const {
    const Eigen::Vector3d* const p = controls(point, piece);
    return {w[0] * p[0].x() + w[1] * p[1].x() + w[2] * p[2].x(),
            w[0] * p[0].y() + w[1] * p[1].y() + w[2] * p[2].y(),
            w[0] * p[0].z() + w[1] * p[1].z() + w[2] * p[2].z()};
  }

 private:
  MeshPaths(const Object& object, const Exposure& exposure);

  const Object* object_;
  double open_, close_;
  bool mirrored_ = false, opaque_looks_ = true;
  int degree_ = 2;
  std::size_t stride_ = 0;  ///< control points for each point: neighbouring pieces share one
  std::vector<double> cuts_;
  std::vector<Eigen::Vector3d> controls_;
};

}  // namespace swept::stochastic
