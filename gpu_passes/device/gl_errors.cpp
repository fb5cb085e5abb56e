#include "gpu_passes/device/gl_errors.h"

#include <array>
#include <string>

#include <epoxy/gl.h>

namespace swept {
namespace {

/// Errors come one by one; a lost context may give one at every call.
constexpr int most_errors = 64;

std::string name_of(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_CONTEXT_LOST:
      return "GL_CONTEXT_LOST";
    default:
      return std::to_string(error);
  }
}

/// The oldest message that is kept; the log is empty afterwards.
std::string take_message() {
  std::array<char, 1024> text{};
  std::string oldest;
  while (glGetDebugMessageLog(1, static_cast<GLsizei>(text.size()), nullptr, nullptr, nullptr, nullptr,
                              nullptr, text.data()) == 1)
    if (oldest.empty()) oldest = text.data();
  return oldest;
}

}  // namespace

void keep_error_messages() {
  glEnable(GL_DEBUG_OUTPUT);
  glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_FALSE);
  glDebugMessageControl(GL_DONT_CARE, GL_DEBUG_TYPE_ERROR, GL_DONT_CARE, 0, nullptr, GL_TRUE);
}

Status take_errors(const char* doing) {
  GLenum first = GL_NO_ERROR;
  for (int i = 0; i < most_errors; ++i) {
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) break;
    if (first == GL_NO_ERROR) first = error;
  }
  if (first == GL_NO_ERROR) return Done{};
  const std::string message = take_message();
  if (first == GL_OUT_OF_MEMORY)
    return Error{"", "gpu", std::string("not enough memory on the GPU while ") + doing,
                 ErrorKind::out_of_memory};
  return Error{"", "gpu",
               "OpenGL error " + name_of(first) + " while " + doing + (message.empty() ? "" : ": " + message),
               ErrorKind::device};
}

}  // namespace swept
