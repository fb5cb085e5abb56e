// What a study consists of.
#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "splat/result.h"
#include "tools/study/runner.h"
#include "tools/study/table1.h"

namespace swept {

enum class StudyPart {
  scenes,      ///< accuracy against time, with pictures
  motion,      ///< error and cost against the length of the motion
  points,      ///< cost against the number of points
  table1,      ///< Heinzle et al. 2010, Table 1
  traversal,   ///< Gribel et al. 2013, Tables 1 and 2; only where it is asked for
  visibility,  ///< visibility accuracy of meshes, and intervals that are merged; so are these
  ronnow,      ///< Rönnow et al. 2021, Table 1
  hierarchy,   ///< moving boxes beside bins
};

struct StudyOptions {
  std::vector<std::string> scenes;         ///< scene files; empty: all that come with the program
  std::set<StudyPart> parts;               ///< empty: all, or all but table1 if quick
  std::set<std::string> methods;           ///< ids of study_methods(); empty: all that the build has
  std::optional<std::array<int, 2>> size;  ///< of the film; else the scene's, with a longest side of 384 px
  bool quick = false;                      ///< few settings, a tenth of the points, a longest side of 160 px
  double points_scale = 1.0;               ///< of all generated objects
  std::vector<int> triangles;              ///< as in MeshTableOptions
  std::vector<double> motions_px;          ///< likewise
  std::vector<int> films_px;               ///< likewise
  std::vector<std::string> looks;          ///< likewise
  RunnerOptions runner;
};

struct StudyPlan {
  std::vector<Task> scenes, motion, points;
  std::vector<std::pair<PaperRow, Task>> table1;
};

/// Reads every scene once, to know what it is. Scenes that come with the program are written to the study's
/// folder. Errors: a scene that cannot be read or has no points, a folder that cannot be written.
[[nodiscard]] Result<StudyPlan> plan_study(const StudyOptions& options);

}  // namespace swept
