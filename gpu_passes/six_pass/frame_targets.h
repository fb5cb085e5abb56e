// The textures that passes draw into.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "gpu_passes/device/gl_object.h"
#include "gpu_passes/six_pass/passes.h"
#include "splat/result.h"

namespace swept {

/// All targets of one window size. A context must be current in every call.
class FrameTargets {
 public:
  /// Fails where the device has no textures of that size, or no memory for them.
  [[nodiscard]] static Result<FrameTargets> create(int width, int height);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] GLuint texture(Target target) const {
    return textures_[static_cast<std::size_t>(target)].name();
  }

  /// A framebuffer of the pass's targets, and a depth buffer if it tests depth.
  [[nodiscard]] Result<GlFramebuffer> framebuffer(const Pass& pass) const;
  /// channels(target) floats per pixel, rows top to bottom; waits for the GPU.
  [[nodiscard]] std::vector<float> read(Target target) const;
  /// The same into the bound pixel-pack buffer, from byte `offset` on, without waiting.
  void read_into_buffer(Target target, std::size_t offset) const;
  [[nodiscard]] std::size_t value_count(Target target) const;

 private:
  FrameTargets() = default;
  void read_to(Target target, void* to) const;

  int width_ = 0, height_ = 0;
  std::array<GlTexture, target_count> textures_;
  GlTexture depth_;
};

}  // namespace swept
