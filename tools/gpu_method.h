// The GPU modes as the command sees them; without SWEPT_GPU, what says that they are not there.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "splat/result.h"
#include "tools/frame_renderer.h"

namespace swept {

struct GpuChoice {
  bool still_frames = false;   ///< temporal supersampling, else six passes
  int subframes = 0;           ///< [0, 65536]; 0: chosen from the motion
  bool lookup_tables = false;  ///< six passes: exp and erf from textures
  bool clamp_motion = false;   ///< six passes: the paper's bent motion
  std::string device;          ///< an id of list_gpus(); empty: SWEPT_GPU, or the first that works
};

/// A renderer that opens its device at the first frame, and keeps it.
[[nodiscard]] std::unique_ptr<FrameRenderer> gpu_frames(const GpuChoice& choice);

/// One line for each device: its id, then what it is, or why it cannot be used.
[[nodiscard]] Result<std::vector<std::string>> describe_gpus();

}  // namespace swept
