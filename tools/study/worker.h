// One timed render in a process of its own, so that memory is counted for it alone, and a render that crashes
// or hangs is one failed cell.
#pragma once

#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "splat/result.h"
#include "tools/study/methods.h"
#include "tools/study/variant.h"

namespace swept {

struct WorkOrder {
  Variant variant;
  Setting setting;
  MethodOptions options;
  std::string image;    ///< where to write the EXR; empty: nowhere
  bool warm_up = true;  ///< first render a few of the points, untimed
};

struct WorkDone {
  double seconds = 0.0;  ///< wall time of the render, from the scene in memory to the image in memory
  std::optional<double> fragments, events, rays;
  std::optional<double> error_rmse, error_psnr_db;  ///< the reference's own estimate
  double peak_memory_bytes = 0.0;                   ///< resident, of the process with scene and image
  std::string device;                               ///< of the GPU methods
};

/// Runs the order in a child process and waits for it, `limit_seconds` at most. The error's reason says how
/// the render failed, or how the process ended.
[[nodiscard]] Result<WorkDone> run_in_child(const WorkOrder& order, double limit_seconds);

/// The command that the child is: an order on stdin, what was done on stdout, both JSON. Not shown in the
/// help.
void add_study_worker_command(CLI::App& app, int& exit_code);

}  // namespace swept
