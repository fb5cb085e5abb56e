// A mesh over the whole exposure: the paths of its points through camera space, as Bézier curves of one
// degree in stretches of time. Source: Gribel et al. 2013, section 3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

#include "splat/camera.h"
#include "splat/interval/edge_function.h"
#include "splat/scene.h"

namespace swept {

/// How far `curve` is on the film from where `truth` is, px, at the most; a difference of depths counts as
/// one to the side. Both in camera space.
///
/// With d = curve − truth, the image moves by f (d_xy − (truth_xy / truth_z) d_z) / curve_z. By Cauchy and
/// Schwarz that is no longer than f |d| √(1 + tan²) / curve_z, tan being that of truth's direction to the
/// axis, and with the greater tangent of the two no more than f (|d| / |curve|) (1 + tan²): an angle, which
/// means something beside and behind the eye too, times what the film makes of one. Beyond `most_tangent`,
/// where no film is, that of the film's edge counts; depths below `near` count as `near`.
[[nodiscard]] double off_path_px(const Eigen::Vector3d& curve, const Eigen::Vector3d& truth,
                                 const Projection& film, double near, double most_tangent);

/// Of the direction to the farthest corner of the film at mid-shutter; 0 where all are parallel.
[[nodiscard]] double film_tangent(const Scene& scene, const Exposure& exposure);

class MovingMesh {
 public:
  /// Over `exposure`, of all rows, evenly in time, which is 0 where it opens and 1 where it closes. Paths
  /// that are polynomials of degree ≤ 3 in camera space are taken as they are, between the keys of anything.
  /// Others, those that turn among them, become parabolas through the ends and the middle of stretches so
  /// short that none is farther than `tolerance_px` from the path on the film: see off_path_px(). Error: what
  /// turns too fast to be followed. Throws Stopped.
  [[nodiscard]] static Result<MovingMesh> follow(const Scene& scene, const Object& object,
                                                 const Exposure& exposure, double tolerance_px,
                                                 const std::stop_token& stop) {
    return follow(scene, object, exposure, tolerance_px, most_path_degree, film_tangent(scene, exposure),
                  stop);
  }
  /// The same for polynomials of degree ≤ `most_degree`, which is 2 or 3; and `tolerance_px` holds out to
  /// directions that have `most_tangent` to the axis.
  [[nodiscard]] static Result<MovingMesh> follow(const Scene& scene, const Object& object,
                                                 const Exposure& exposure, double tolerance_px,
                                                 int most_degree, double most_tangent,
                                                 const std::stop_token& stop);

  [[nodiscard]] const Object& object() const { return *object_; }
  /// Whether object and camera mirror it, so that its front is where it looks clockwise.
  [[nodiscard]] bool mirrored(std::size_t stretch) const { return mirrored_[stretch] != 0; }
  [[nodiscard]] int degree() const { return degree_; }
  /// What its paths take.
  [[nodiscard]] std::size_t bytes() const { return controls_.size() * sizeof(Eigen::Vector3d); }
  [[nodiscard]] std::size_t stretches() const { return times_.size() - 1; }
  /// Where stretch `s` begins; and where the last one ends.
  [[nodiscard]] double time(std::size_t s) const { return times_[s]; }
  /// The frame in which stretch `s` begins. Colours change evenly over each stretch.
  [[nodiscard]] double frame(std::size_t s) const { return open_ + times_[s] * (close_ - open_); }
  /// Whether no light comes through a triangle's texture, if it has one.
  [[nodiscard]] bool opaque_texture(std::size_t triangle) const {
    return opaque_textures_[object_->material_of.empty() ? 0 : object_->material_of[triangle]] != 0;
  }
  /// Of a point: degree() + 1.
  [[nodiscard]] const Eigen::Vector3d* path(std::size_t stretch, std::size_t point) const {
    return &controls_[(stretch * object_->cloud.size() + point) * static_cast<std::size_t>(degree_ + 1)];
  }

 private:
  MovingMesh() = default;

  const Object* object_ = nullptr;
  int degree_ = 1;
  double open_ = 0.0, close_ = 0.0;    ///< frames
  std::vector<char> opaque_textures_;  ///< by material, or of all
  std::vector<double> times_;
  std::vector<char> mirrored_;  ///< by stretch
  std::vector<Eigen::Vector3d> controls_;
};

}  // namespace swept
