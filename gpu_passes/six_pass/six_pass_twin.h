// The six-pass mode in plain double precision on one CPU thread: what the passes compute, without what a GPU
// does to it. Slow; for tests and for telling apart the approximation from its implementation.
#pragma once

#include <cstddef>
#include <vector>

#include "gpu_passes/gpu_renderer.h"
#include "splat/kernel/kernel_set.h"

namespace swept {

/// What one sub-frame's passes leave at each pixel of the window, rows top to bottom.
struct TwinTargets {
  /// Depth of the nearest disc plus its tolerance; +∞ where there is none.
  std::vector<double> limit_open, limit_close;
  /// Shares of the sub-frame; 2 and −1 where nothing visible covers the pixel.
  std::vector<double> earliest, latest;
  std::vector<double> color_sum;   ///< 4 per pixel: Σ I w, Σ I
  std::vector<double> behind_sum;  ///< the same of hidden kernels; 0 for hard coverage
  /// 2 per pixel: Σ I z of visible and of hidden kernels, z being the kernel's depth in the middle
  /// of its interval; for soft coverage where it has its weight.
  std::vector<double> depth_sum;
};

/// Passes 1 to 5 over given kernels, all of one segment. Film and image model are the scene's.
[[nodiscard]] TwinTargets twin_passes(const KernelSet& set, const Scene& scene, GpuMethod method);

/// The same image as GpuRenderer::render, lookup tables aside. Errors: options or scene out of range, opacity
/// below 1.
[[nodiscard]] Result<Rendered> render_six_pass_twin(const Scene& scene, const GpuRenderOptions& options = {});

}  // namespace swept
