// The scenes that the engines are timed on: closed textured objects, and what is hard for one engine or the
// other.
#pragma once

#include <string>
#include <vector>

#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

struct EngineScene {
  std::string name;  ///< object, points, motion in px
  Scene scene;
};

/// Names of the scenes of the table, in its order: those of 20,000 to a million points.
[[nodiscard]] std::vector<std::string> engine_scene_names();

/// 1024 × 1024 px; the exposure is the frame from 0 to 1. Also "random-K": scene K of those that nobody
/// chose, one to three shapes of 3,000 to 100,000 points on a film of 192 to 512 px that move by 2 to 150 px,
/// turn or stand, and sometimes are seen through or before a moving camera. The error's field is "scene".
[[nodiscard]] Result<EngineScene> make_engine_scene(const std::string& name);

}  // namespace swept
