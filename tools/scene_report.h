// What a scene is, in numbers: the facts behind `swept info`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "splat/io/scene_file.h"
#include "splat/scene.h"
#include "tools/effect_plan.h"

namespace swept {

struct ObjectReport {
  std::string name, source;
  std::size_t points = 0, keys = 0;
  bool points_move = false;        ///< within the object, during the exposure
  bool object_moves = false;       ///< its transform, during the exposure
  std::string velocity_unit;       ///< "per_second" or "per_frame" of velocities that move points; else empty
  double longest_streak_px = 0.0;  ///< as longest_streak_px()
  bool has_opacity = false;        ///< some point is not opaque
  bool two_sided = true;
  int segments = 1;  ///< linear motion segments, resolved
  ObjectPlan plan;
  bool splats = false;  ///< Gaussian splats, not discs
  /// World-space box of the discs, or of the splats' centres, at the shutter's open, middle and close; low >
  /// high if there are no points.
  Eigen::Vector3d low, high;
};

struct CameraReport {
  Eigen::Vector3d eye, right, down, forward;                    ///< world space, mid-shutter
  double fov_x_degrees = 0.0, fov_y_degrees = 0.0, near = 0.0;  ///< near in world units
  double height = 0.0;                  ///< of what an orthographic camera sees, world units; 0: it is none
  Eigen::Vector2d focal_px, center_px;  ///< along x and y; the principal point, from the film's upper left
  bool moves = false;                   ///< during the exposure
};

struct SceneReport {
  std::string hash;  ///< SceneFile::hash(frame); left to the caller
  double frame = 0.0, exposure_seconds = 0.0, shutter_angle_degrees = 0.0;
  CameraReport camera;
  std::vector<ObjectReport> objects;
  std::vector<std::string> effects;  ///< what rendering this frame calls for, one sentence each
  std::vector<std::string> notes;    ///< of the readers
};

/// `scene` is what `file` loaded last.
[[nodiscard]] SceneReport report_scene(const SceneFile& file, const Scene& scene);

}  // namespace swept
