// Draws sub-frames by walking a table of passes.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "gpu_passes/device/gl_object.h"
#include "gpu_passes/device/pass_timers.h"
#include "gpu_passes/device/readback.h"
#include "gpu_passes/six_pass/frame_block.h"
#include "gpu_passes/six_pass/frame_targets.h"
#include "gpu_passes/six_pass/instance.h"
#include "gpu_passes/six_pass/passes.h"
#include "splat/result.h"

namespace swept {

/// What all sub-frames of a frame share.
struct FrameSetup {
  int width = 0, height = 0;     ///< px
  std::span<const Pass> passes;  ///< must outlive the runner
  bool lookup_tables = false;
  FrameBlock block;
};

/// All of it has been told to the GPU, and some of it may be done.
struct DrawnFrame {
  Readback pixels;
  std::span<const Pass> passes;
  PassSeconds seconds;      ///< one per pass, complete after PassRunner::wait(); none without such a clock
  std::size_t batches = 0;  ///< buffers that the fullest sub-frame took
};

/// Nothing here waits for the GPU but wait(), read(), and draw_subframe() once the GPU is `subframes_ahead`
/// behind: what is uploaded and not yet drawn takes memory. A context must be current in every call,
/// destruction included, and always the same.
class PassRunner {
 public:
  static constexpr std::size_t subframes_ahead = 2;

  /// Compiles all programs.
  [[nodiscard]] static Result<PassRunner> create(std::size_t batch_kernels);

  /// Starts a frame, all zero. One that was begun and not ended is given up.
  [[nodiscard]] Status begin_frame(const FrameSetup& setup);
  /// Draws and adds one sub-frame.
  void draw_subframe(std::span<const Instance> instances);
  /// Sends the frame's pixels after it. `buffer` as in Readback. Fails where anything went wrong since
  /// begin_frame(), as far as is known yet.
  [[nodiscard]] Result<DrawnFrame> end_frame(PixelBuffer buffer = {});
  /// Until the frame is drawn; says if anything went wrong.
  [[nodiscard]] Status wait(const DrawnFrame& frame);

  /// A target as the last sub-frame left it.
  [[nodiscard]] std::vector<float> read(Target target) const { return targets_->read(target); }

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
  /// A sub-frame that may still be drawn.
  struct Subframe {
    PassTimers timers;
    GlFence done;
  };

  PassRunner() = default;
  [[nodiscard]] Status prepare_targets(const FrameSetup& setup);
  void upload(std::span<const Instance> instances);
  void draw(const Pass& pass);
  [[nodiscard]] const Program& program_of(const Pass& pass) const;

  std::size_t batch_kernels_ = 0;
  bool timed_ = false;
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

  std::array<Subframe, subframes_ahead> subframes_;
  std::size_t next_subframe_ = 0;
  PassSeconds seconds_;  ///< of the frame that is drawn
};

}  // namespace swept
