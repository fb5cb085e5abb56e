// A frame's pixels on their way from the GPU to memory.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "gpu_passes/device/gl_object.h"
#include "gpu_passes/six_pass/frame_targets.h"
#include "splat/result.h"

namespace swept {

/// Memory of the GPU that the processor can read.
struct PixelBuffer {
  GlBuffer buffer;
  std::size_t bytes = 0;
};

/// The frame's colours and depths in a buffer of their own as soon as the GPU gets there, so that the targets
/// are free for the next frame. Its context must be current in every call, destruction included.
class Readback {
 public:
  /// Puts the copy behind all that the context was told to draw. `buffer` may be one that another frame is
  /// done with, or empty.
  Readback(const FrameTargets& targets, PixelBuffer buffer);

  /// Until the GPU is done with the frame.
  [[nodiscard]] Status wait() const;
  /// Of Target::frame_color and Target::frame_depth, rows top to bottom. Must not throw.
  using Visit = std::function<void(std::span<const float> color, std::span<const float> depth)>;
  /// Shows the pixels; waits for them if need be.
  [[nodiscard]] Status read(const Visit& visit) const;
  /// For another frame to use; nothing can be read any more.
  [[nodiscard]] PixelBuffer take_buffer();

 private:
  std::size_t color_count_, depth_count_;
  PixelBuffer buffer_;
  GlFence done_;
};

}  // namespace swept
