// Draws sub-frames by walking a table of passes.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gpu_passes/frame_block.h"
#include "gpu_passes/frame_targets.h"
#include "gpu_passes/gl_object.h"
#include "gpu_passes/instance.h"
#include "gpu_passes/passes.h"
#include "splat/result.h"

namespace swept {

/// A context must be current in every call, destruction included, and always the same.
class PassRunner {
 public:
  /// Compiles all programs.
  [[nodiscard]] static Result<PassRunner> create(std::size_t batch_kernels);

  /// Starts a frame of that size, all zero, to be drawn with `passes`, which must outlive it.
  [[nodiscard]] Status begin_frame(int width, int height, std::span<const Pass> passes, bool lookup_tables);
  /// Draws and adds one sub-frame.
  void draw_subframe(std::span<const Instance> instances, const FrameBlock& block);
  /// Waits for the GPU, and says if anything went wrong since begin_frame().
  [[nodiscard]] Status end_frame();

  /// Of the last sub-frame, or of the frame so far.
  [[nodiscard]] std::vector<float> read(Target target) const { return targets_->read(target); }
  /// Name and seconds of each pass by the GPU's clock, summed over the frame's sub-frames. After end_frame().
  [[nodiscard]] std::vector<std::pair<std::string, double>> pass_seconds() const;
  /// Buffers that the fullest sub-frame of the frame took.
  [[nodiscard]] std::size_t batches() const { return most_batches_; }

 private:
  struct Batch {
    GlBuffer buffer;
    GlVertexArray vertex_array;
    GLsizei count = 0;
  };
  struct Program {
    GlProgram program;
    GLint geometry = -1, time = -1;
  };

  PassRunner() = default;
  void upload(std::span<const Instance> instances);
  void draw(const Pass& pass);
  void collect_timers(std::size_t set);
  [[nodiscard]] const Program& program_of(const Pass& pass) const;

  std::size_t batch_kernels_ = 0;
  std::array<Program, program_count> programs_;
  GlBuffer frame_block_;
  GlVertexArray empty_vertex_array_;
  GlTexture table_;
  std::vector<Batch> batches_;
  std::size_t used_batches_ = 0, most_batches_ = 0;

  std::optional<FrameTargets> targets_;
  std::span<const Pass> passes_;
  std::vector<GlFramebuffer> framebuffers_;  ///< one per pass
  bool lookup_tables_ = false;

  /// Two sets of timers, so that reading one never waits for what was just drawn.
  std::array<std::vector<GlQuery>, 2> timers_;
  std::array<bool, 2> timing_{};
  std::size_t timer_set_ = 0;
  std::vector<double> seconds_;  ///< one per pass
};

}  // namespace swept
