// Time by the GPU's own clock.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "gpu_passes/device/gl_object.h"

namespace swept {

/// One number per pass, summed over a frame's sub-frames.
using PassSeconds = std::shared_ptr<std::vector<double>>;

/// Times the passes of one sub-frame at a time.
class PassTimers {
 public:
  /// Whether the device has such a clock; where it has none there are no timers, and draw() draws.
  [[nodiscard]] static bool available();

  /// Of passes of `frame`, from here on. What was timed before must have been collected.
  void start(PassSeconds frame);
  /// Calls `work` and times what it has the GPU do for a pass.
  void time(std::size_t pass, const std::function<void()>& work);
  /// Adds the times to the frame; waits for those of work that is not done.
  void collect();
  [[nodiscard]] const PassSeconds& frame() const { return frame_; }

 private:
  std::vector<GlQuery> queries_;  ///< one per pass
  PassSeconds frame_;             ///< null: nothing to collect
};

}  // namespace swept
