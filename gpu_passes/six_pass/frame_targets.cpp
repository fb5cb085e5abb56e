#include "gpu_passes/six_pass/frame_targets.h"

#include <algorithm>
#include <string>

#include "gpu_passes/device/gl_errors.h"

namespace swept {
namespace {

GlTexture make_texture(GLenum format, int width, int height) {
  GlTexture texture = GlTexture::make();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_NEAREST);
  glBindTexture(GL_TEXTURE_2D, 0);
  return texture;
}

GLenum read_format(int channel_count) {
  return channel_count == 4 ? GL_RGBA : channel_count == 2 ? GL_RG : GL_RED;
}

}  // namespace

Result<FrameTargets> FrameTargets::create(int width, int height) {
  GLint texture_limit = 0, viewport_limit[2] = {0, 0};
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture_limit);
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport_limit);
  const int limit_x = std::min(texture_limit, viewport_limit[0]),
            limit_y = std::min(texture_limit, viewport_limit[1]);
  if (width > limit_x || height > limit_y)
    return Error{"", "/film",
                 "the window of " + std::to_string(width) + " x " + std::to_string(height) +
                     " px is larger than this device draws, " + std::to_string(limit_x) + " x " +
                     std::to_string(limit_y) + " px; render it in crops",
                 ErrorKind::device};
  FrameTargets targets;
  targets.width_ = width;
  targets.height_ = height;
  for (int i = 0; i < target_count; ++i)
    targets.textures_[static_cast<std::size_t>(i)] =
        make_texture(internal_format(static_cast<Target>(i)), width, height);
  targets.depth_ = make_texture(GL_DEPTH_COMPONENT32F, width, height);
  if (Status status = take_errors("targets were made for the window"); !status) return status.error();
  return targets;
}

Result<GlFramebuffer> FrameTargets::framebuffer(const Pass& pass) const {
  GlFramebuffer framebuffer = GlFramebuffer::make();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  std::vector<GLenum> attachments;
  for (const Target target : pass.targets) {
    attachments.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachments.size()));
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachments.back(), GL_TEXTURE_2D, texture(target), 0);
  }
  if (pass.depth_test)
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_.name(), 0);
  glDrawBuffers(static_cast<GLsizei>(attachments.size()), attachments.data());
  const bool complete = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (!complete)
    return Error{"", "gpu", std::string("this device cannot draw into the targets of ") + pass.name,
                 ErrorKind::device};
  return framebuffer;
}

void FrameTargets::read_to(Target target, void* to) const {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture(target));
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glGetTexImage(GL_TEXTURE_2D, 0, read_format(channels(target)), GL_FLOAT, to);
  glBindTexture(GL_TEXTURE_2D, 0);
}

std::vector<float> FrameTargets::read(Target target) const {
  std::vector<float> values(value_count(target));
  read_to(target, values.data());
  return values;
}

void FrameTargets::read_into_buffer(Target target, std::size_t offset) const {
  // With a pixel-pack buffer bound, OpenGL takes the address for an offset in it.
  // NOLINTNEXTLINE(performance-no-int-to-ptr)
  read_to(target, reinterpret_cast<void*>(offset));
}

std::size_t FrameTargets::value_count(Target target) const {
  return static_cast<std::size_t>(channels(target)) * static_cast<std::size_t>(width_) *
         static_cast<std::size_t>(height_);
}

}  // namespace swept
