// OpenGL as a test wants it: calls counted, or answered otherwise than the driver would. libepoxy calls
// through function pointers that anyone may set.
#pragma once

#include <type_traits>
#include <utility>

#include <epoxy/gl.h>

namespace swept::test {

/// Puts a function in the place of an OpenGL function for as long as it lives; one at a time for each.
template <auto& pointer>
class Replaced {
 public:
  using Function = std::remove_reference_t<decltype(pointer)>;
  explicit Replaced(Function function)
      : original_(std::exchange(pointer, function)),
        function_(function),
        outer_(std::exchange(current_, this)) {}
  ~Replaced() {
    pointer = original_;
    current_ = outer_;
  }
  Replaced(const Replaced&) = delete;
  Replaced& operator=(const Replaced&) = delete;

  /// The function replaced.
  template <class... Arguments>
  static auto original(Arguments... arguments) {
    // Where it was never called before, libepoxy looks it up now, and sets the pointer.
    pointer = current_->original_;
    struct Restore {
      ~Restore() { current_->original_ = std::exchange(pointer, current_->function_); }
    } restore;
    return pointer(arguments...);
  }

 private:
  static inline Replaced* current_ = nullptr;
  Function original_, function_;
  Replaced* outer_;
};

/// Counts OpenGL objects, fences among them, that were made and not deleted while it lives.
class LiveObjects {
 public:
  LiveObjects() { count_ = 0; }
  [[nodiscard]] static int count() { return count_; }

 private:
  static inline int count_ = 0;

  template <auto& pointer>
  struct Made : Replaced<pointer> {
    Made()
        : Replaced<pointer>([](GLsizei n, GLuint* names) {
            Replaced<pointer>::original(n, names);
            count_ += n;
          }) {}
  };
  template <auto& pointer>
  struct Deleted : Replaced<pointer> {
    Deleted()
        : Replaced<pointer>([](GLsizei n, const GLuint* names) {
            Replaced<pointer>::original(n, names);
            count_ -= n;
          }) {}
  };
  template <auto& pointer>
  struct DeletedOne : Replaced<pointer> {
    DeletedOne()
        : Replaced<pointer>([](auto name) {
            Replaced<pointer>::original(name);
            --count_;
          }) {}
  };

  Made<epoxy_glGenBuffers> made_buffers_;
  Made<epoxy_glGenTextures> made_textures_;
  Made<epoxy_glGenFramebuffers> made_framebuffers_;
  Made<epoxy_glGenVertexArrays> made_vertex_arrays_;
  Made<epoxy_glGenQueries> made_queries_;
  Deleted<epoxy_glDeleteBuffers> deleted_buffers_;
  Deleted<epoxy_glDeleteTextures> deleted_textures_;
  Deleted<epoxy_glDeleteFramebuffers> deleted_framebuffers_;
  Deleted<epoxy_glDeleteVertexArrays> deleted_vertex_arrays_;
  Deleted<epoxy_glDeleteQueries> deleted_queries_;
  DeletedOne<epoxy_glDeleteShader> deleted_shader_;
  DeletedOne<epoxy_glDeleteProgram> deleted_program_;
  DeletedOne<epoxy_glDeleteSync> deleted_fence_;
  Replaced<epoxy_glCreateShader> made_shader_{[](GLenum stage) {
    ++count_;
    return Replaced<epoxy_glCreateShader>::original(stage);
  }};
  Replaced<epoxy_glCreateProgram> made_program_{[] {
    ++count_;
    return Replaced<epoxy_glCreateProgram>::original();
  }};
  Replaced<epoxy_glFenceSync> made_fence_{[](GLenum condition, GLbitfield flags) {
    ++count_;
    return Replaced<epoxy_glFenceSync>::original(condition, flags);
  }};
};

}  // namespace swept::test
