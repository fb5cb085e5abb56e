#include "gpu_passes/device/readback.h"

#include <utility>

namespace swept {

Readback::Readback(const FrameTargets& targets, PixelBuffer buffer)
    : color_count_(targets.value_count(Target::frame_color)),
      depth_count_(targets.value_count(Target::frame_depth)),
      buffer_(std::move(buffer)) {
  if (!buffer_.buffer) buffer_.buffer = GlBuffer::make();
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.buffer.name());
  const std::size_t bytes = (color_count_ + depth_count_) * sizeof(float);
  if (bytes != buffer_.bytes)
    glBufferData(GL_PIXEL_PACK_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STREAM_READ);
  buffer_.bytes = bytes;
  targets.read_into_buffer(Target::frame_color, 0);
  targets.read_into_buffer(Target::frame_depth, color_count_ * sizeof(float));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  done_ = GlFence::make();
  // On its way, whether or not anybody waits.
  glFlush();
}

Status Readback::wait() const {
  if (done_.wait()) return Done{};
  return Error{"", "gpu", "the device was lost while it drew the frame", ErrorKind::device};
}

Status Readback::read(const Visit& visit) const {
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.buffer.name());
  const auto* values = static_cast<const float*>(
      glMapBufferRange(GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(buffer_.bytes), GL_MAP_READ_BIT));
  bool intact = false;
  if (values != nullptr) {
    visit({values, color_count_}, {values + color_count_, depth_count_});
    // False where the memory was taken away under it, as a change of the screen's mode may do.
    intact = glUnmapBuffer(GL_PIXEL_PACK_BUFFER) == GL_TRUE;
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  if (intact) return Done{};
  return Error{"", "gpu", "the frame cannot be read back from the device", ErrorKind::device};
}

PixelBuffer Readback::take_buffer() { return std::exchange(buffer_, {}); }

}  // namespace swept
