// Where the points of a scene are at an instant, by formulas of the reference's own: nothing here is shared
// with splat/motion.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "splat/scene.h"

namespace swept::reference {

/// Whether the reference places the points of the scene itself: paths that curve, points that come and go,
/// colours that change.
[[nodiscard]] bool has_own_paths(const Scene& scene);

/// Premultiplied RGBA of point `i` at `frame`.
[[nodiscard]] Eigen::Vector4d light_of(const SurfelCloud& cloud, std::size_t i, double frame);

/// A scene of which the points are placed.
class PosedScene {
 public:
  /// `scene` must outlive it.
  explicit PosedScene(const Scene& scene);

  /// The scene with clouds that stand where those of the given one are at `frame`, of the points that exist
  /// then. It changes with the next call.
  const Scene& at(double frame);

 private:
  const Scene& scene_;
  Scene still_;
};

}  // namespace swept::reference
