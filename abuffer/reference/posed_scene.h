// Where the points of a scene are at an instant, by formulas of the reference's own: nothing here is shared
// with splat/motion.
#pragma once

#include "splat/scene.h"

namespace swept::reference {

/// Whether the reference places the points of the scene itself: paths that curve, points that come and go.
[[nodiscard]] bool has_own_paths(const Scene& scene);

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
