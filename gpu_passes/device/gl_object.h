// OpenGL names with an owner. They must be destroyed while their context is current.
#pragma once

#include <utility>

#include <epoxy/gl.h>

namespace swept {

/// One name of the kind that Kind::create and Kind::destroy make and delete. Move-only; 0 when empty.
template <class Kind>
class GlObject {
 public:
  GlObject() = default;
  [[nodiscard]] static GlObject make(auto... arguments) {
    GlObject object;
    object.name_ = Kind::create(arguments...);
    return object;
  }
  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlObject() {
    if (name_ != 0) Kind::destroy(name_);
  }

  [[nodiscard]] GLuint name() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  GLuint name_ = 0;
};

namespace gl_kind {

struct Buffer {
  static GLuint create() {
    GLuint name = 0;
    glGenBuffers(1, &name);
    return name;
  }
  static void destroy(GLuint name) { glDeleteBuffers(1, &name); }
};
struct Texture {
  static GLuint create() {
    GLuint name = 0;
    glGenTextures(1, &name);
    return name;
  }
  static void destroy(GLuint name) { glDeleteTextures(1, &name); }
};
struct Framebuffer {
  static GLuint create() {
    GLuint name = 0;
    glGenFramebuffers(1, &name);
    return name;
  }
  static void destroy(GLuint name) { glDeleteFramebuffers(1, &name); }
};
struct VertexArray {
  static GLuint create() {
    GLuint name = 0;
    glGenVertexArrays(1, &name);
    return name;
  }
  static void destroy(GLuint name) { glDeleteVertexArrays(1, &name); }
};
struct Query {
  static GLuint create() {
    GLuint name = 0;
    glGenQueries(1, &name);
    return name;
  }
  static void destroy(GLuint name) { glDeleteQueries(1, &name); }
};
struct Shader {
  static GLuint create(GLenum stage) { return glCreateShader(stage); }
  static void destroy(GLuint name) { glDeleteShader(name); }
};
struct Program {
  static GLuint create() { return glCreateProgram(); }
  static void destroy(GLuint name) { glDeleteProgram(name); }
};

}  // namespace gl_kind

using GlBuffer = GlObject<gl_kind::Buffer>;
using GlTexture = GlObject<gl_kind::Texture>;
using GlFramebuffer = GlObject<gl_kind::Framebuffer>;
using GlVertexArray = GlObject<gl_kind::VertexArray>;
using GlQuery = GlObject<gl_kind::Query>;
using GlShader = GlObject<gl_kind::Shader>;
using GlProgram = GlObject<gl_kind::Program>;

/// A place in the stream of commands that one can wait for. Move-only; nothing to wait for when empty.
class GlFence {
 public:
  GlFence() = default;
  [[nodiscard]] static GlFence make() {
    GlFence fence;
    fence.sync_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    return fence;
  }
  GlFence(GlFence&& other) noexcept : sync_(std::exchange(other.sync_, nullptr)) {}
  GlFence& operator=(GlFence&& other) noexcept {
    std::swap(sync_, other.sync_);
    return *this;
  }
  ~GlFence() {
    if (sync_ != nullptr) glDeleteSync(sync_);
  }

  /// Until the GPU is there. False where it will never be: the device is gone.
  [[nodiscard]] bool wait() const {
    if (sync_ == nullptr) return true;
    constexpr GLuint64 second = 1'000'000'000;
    GLenum state = GL_TIMEOUT_EXPIRED;
    while (state == GL_TIMEOUT_EXPIRED) state = glClientWaitSync(sync_, GL_SYNC_FLUSH_COMMANDS_BIT, second);
    return state != GL_WAIT_FAILED;
  }

 private:
  GLsync sync_ = nullptr;
};

}  // namespace swept
