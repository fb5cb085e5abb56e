// What a run did, for machines.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "splat/io/image_file.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "tools/effect_plan.h"
#include "tools/layer_options.h"

namespace swept {

struct FrameStatistics {
  double frame = 0.0;
  std::string output, scene_hash;
  bool skipped = false;
  double load_seconds = 0.0, render_seconds = 0.0, write_seconds = 0.0;  ///< wall time
  Statistics statistics;                                                 ///< the renderer's own
  std::vector<std::string> notes;  ///< of the readers, and on options that change nothing
  std::vector<ObjectPlan> plan;    ///< as effect_plan()
};

struct RunStatistics {
  std::string software, scene, method;
  std::string picture;  ///< the method with what of its options is in the image, one line
  ExrPixels pixels = ExrPixels::float32;
  LayerOptions layers;
  RenderControl layer_control;
  int width = 0, height = 0;                            ///< of the film, px
  std::vector<std::pair<std::string, double>> options;  ///< of the method
  double peak_memory_bytes = 0.0;                       ///< resident, of the whole process
  std::vector<FrameStatistics> frames;
};

/// One JSON object, indented; numbers that are not finite become null.
[[nodiscard]] std::string to_json(const RunStatistics& run);

}  // namespace swept
