// The scenes that the engines are timed on: closed textured objects, and what is hard for one engine or the
// other.
#pragma once

#include <string>
#include <vector>

#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// The stage of the table's scenes: a square film whose eye is so far before the origin.
[[nodiscard]] Scene engine_stage();
inline constexpr int engine_film_px = 1024;
inline constexpr double engine_distance = 4.0, engine_tan_half_fov = 0.364;
/// At the origin.
inline constexpr double engine_px_per_unit = 0.5 * engine_film_px / engine_tan_half_fov / engine_distance;

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
