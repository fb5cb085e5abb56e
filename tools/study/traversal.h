// Tables 1 and 2 of Gribel et al. 2013, redone: how many of the samples that a traversal tests are inside,
// and how long it takes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "abuffer/stochastic/stochastic.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// A column of the tables.
struct TraversalSetting {
  std::string id, label;
  StochasticOptions options;
};
[[nodiscard]] std::vector<TraversalSetting> traversal_settings(int samples);

/// What traversals are measured on.
struct TraversalScene {
  std::string title;
  std::string paper;  ///< scene of the paper that it is or stands in for; empty: none
  Scene scene;
  std::string error = {};  ///< why there is none
};

struct TraversalCell {
  double efficiency = 0.0;   ///< samples inside / samples tested
  double cpu_seconds = 0.0;  ///< by one thread, the least of the repeats
  double tested = 0.0;
};

struct TraversalRow {
  std::string title, paper, error;  ///< error: why there are no figures; empty: there are
  std::size_t primitives = 0;
  int width = 0, height = 0, samples = 0;
  std::vector<TraversalCell> cells;  ///< of traversal_settings()
};

/// Renders a scene by every traversal, in turns. Those that must be the same image are compared.
[[nodiscard]] TraversalRow measure_traversals(const TraversalScene& scene, int samples, int repeats);

/// A rotation, small triangles and large ones, made up, and cloth ball and horse where the environment
/// variable SWEPT_DATA_DIR names the folder that has them; scene files for these are put into `folder`.
[[nodiscard]] std::vector<TraversalScene> traversal_scenes(int longest_side_px, const std::string& folder);
/// A scene file's own frame, reduced to that size.
[[nodiscard]] TraversalScene traversal_scene(const std::string& title, const std::string& path,
                                             int longest_side_px);

/// What made-up scenes are of: a film whose eye looks along −z from z = 5, with the shutter open from frame 0
/// to 1.
[[nodiscard]] Scene square_stage(int side_px);
/// A corner of triangles. Returns its index.
std::uint32_t add_point(Object& object, const Eigen::Vector3d& position, const Eigen::Vector3f& color);
/// Over the exposure, about an axis through the object's origin.
void turn(Object& object, double degrees, const Eigen::Vector3d& axis);

/// Which of the paper's findings hold, in two sentences. Of rows without errors, at least one.
[[nodiscard]] std::vector<std::string> traversal_findings(const std::vector<TraversalRow>& rows);

[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<TraversalRow>& rows);

}  // namespace swept
