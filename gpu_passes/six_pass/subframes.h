// The exposure in equal parts. Source: Heinzle et al. 2010, section 5.5.
#pragma once

#include "gpu_passes/gpu_renderer.h"
#include "splat/kernel/kernel_set.h"
#include "splat/scene.h"

namespace swept {

/// Kernels of each sub-frame: of its motion, one linear segment per surfel; or standing still at its middle.
class Subframes {
 public:
  /// Options and scene must be valid.
  Subframes(const Scene& scene, const GpuRenderOptions& options);

  /// options.subframes or the number chosen; 1 where nothing moves and all would be the same.
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] bool still() const { return nothing_moves_; }
  /// Of sub-frame `j` in [0, count()). Shutter time 0 and 1 are the sub-frame's own ends.
  [[nodiscard]] KernelSet kernels(int j);

 private:
  [[nodiscard]] int choose();

  Scene scene_;  ///< with one segment a sub-frame
  bool still_frames_, clamp_motion_, nothing_moves_;
  int count_;
};

}  // namespace swept
