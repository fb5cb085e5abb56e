// How evenly a filtered disc turns, grows or comes nearer along a segment. Private to splat.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Core>
#include <Eigen/LU>

#include "splat/camera.h"
#include "splat/kernel/turning_kernel.h"
#include "splat/motion/cut.h"

namespace swept {

/// What a parabola may leave of the path, of the tolerance: as much, root mean square, as a chord, whose
/// error is made good in the mean.
inline constexpr double bent_part = 0.4;

/// A filtered disc seen from beside its centre: where its coordinates (u, v) are on the film and how far
/// along the ray, px.
struct FilmDisc {
  Eigen::Matrix2d film;
  Eigen::RowVector2d along;
  double weight;

  FilmDisc(const FilteredDisc& disc, const Eigen::Vector3d& center, const Projection& projection)
      : weight(disc.weight) {
    const double scale = projection.focal_px / projection.divisor(center.z());
    const Eigen::Vector2d ray =
        projection.orthographic ? Eigen::Vector2d::Zero() : Eigen::Vector2d(center.head<2>() / center.z());
    film.col(0) = scale * (disc.axis_u.head<2>() - ray * disc.axis_u.z());
    film.col(1) = scale * (disc.axis_v.head<2>() - ray * disc.axis_v.z());
    along = scale * Eigen::RowVector2d(disc.axis_u.z(), disc.axis_v.z());
  }
};

/// What DiscTurn makes of three discs of one segment, beside the true ones.
class TurnOnFilm {
 public:
  /// The ends turned towards the middle (turn_towards()).
  TurnOnFilm(const FilmDisc& first, const FilmDisc& middle, const FilmDisc& last)
      : middle_(middle),
        weight_first_(first.weight),
        weight_last_(last.weight),
        here_(seen(middle)),
        rate_(0.5 * (seen(last) - seen(first))),
        bend_(0.5 * (seen(last) + seen(first)) - here_) {}

  /// The height of the parabola that places of the middle's rim go along.
  [[nodiscard]] double bend_px() const { return bend_.norm(); }
  /// How far the disc that is there at a share of the time is from it.
  [[nodiscard]] double off_px(const FilmDisc& truth, double share) const {
    const double x = 2.0 * share - 1.0;
    return (seen(truth) - (here_ + x * rate_ + x * x * bend_)).norm();
  }
  /// The same of weights, to that of the middle; and how much they change over the segment.
  [[nodiscard]] double weight_off(const FilmDisc& truth, double share) const {
    const double x = 2.0 * share - 1.0, w = middle_.weight;
    const double rate = 0.5 * (weight_last_ - weight_first_), bend = 0.5 * (weight_last_ + weight_first_) - w;
    return std::abs(truth.weight - (w + x * rate + x * x * bend)) / w;
  }
  [[nodiscard]] double weight_change() const {
    return std::abs(weight_last_ - weight_first_) / middle_.weight;
  }

 private:
  using Matrix = Eigen::Matrix<double, 3, 2>;
  /// What a ray through a place of the middle's rim has for coordinates, as a length there, and depth.
  [[nodiscard]] Matrix seen(const FilmDisc& disc) const {
    const Eigen::Matrix2d coordinates = disc.film.inverse() * middle_.film;
    Matrix m;
    m.topRows<2>() = middle_.film * coordinates;
    m.row(2) = disc.along * coordinates;
    return m;
  }

  FilmDisc middle_;
  double weight_first_, weight_last_;
  Matrix here_, rate_, bend_;
};

/// The axes of a segment.
struct PathCutter::Axes {
  bool follow = false;                                       ///< the disc, at the ends and in the middle
  FilteredDisc middle;                                       ///< with `turn`
  std::optional<TurnOnFilm> turn;                            ///< none: they are the middle's
  std::optional<std::array<KernelPlane<double>, 3>> planes;  ///< with `turn`

  /// What a ray has for coordinates at a share of the time, by TurningPlane.
  [[nodiscard]] Eigen::Vector3d along(const Eigen::Vector2d& ray, double share) const {
    const auto at = [&](std::size_t k) {
      const RayCoordinates<double> c = (*planes)[k].along(ray.x(), ray.y());
      return Eigen::Vector3d(c.u, c.v, c.z);
    };
    const Eigen::Vector3d a = at(0), m = at(1), b = at(2);
    const double x = 2.0 * share - 1.0;
    return m + 0.5 * x * (b - a) + x * x * (0.5 * (a + b) - m);
  }
};

}  // namespace swept
