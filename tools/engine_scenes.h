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

/// 1024 × 1024 px; the exposure is the frame from 0 to 1. The error's field is "scene".
[[nodiscard]] Result<EngineScene> make_engine_scene(const std::string& name);

}  // namespace swept
