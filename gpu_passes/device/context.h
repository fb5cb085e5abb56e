// An OpenGL context without a display, and its turn on a thread.
#pragma once

#include <string>
#include <vector>

#include <epoxy/egl.h>

#include "gpu_passes/gpu_renderer.h"
#include "splat/result.h"

namespace swept {

/// OpenGL 4.3 core or later through EGL: on an EGL device, or on Mesa's surfaceless platform. Displays belong
/// to the process and are never terminated: someone else may be using them.
class GlContext {
 public:
  /// `device` as in GpuOptions.
  [[nodiscard]] static Result<GlContext> create(const std::string& device);

  GlContext(GlContext&& other) noexcept;
  GlContext& operator=(GlContext&& other) noexcept;
  ~GlContext();

  [[nodiscard]] const GpuDevice& device() const { return device_; }
  [[nodiscard]] EGLDisplay display() const { return display_; }
  [[nodiscard]] EGLContext handle() const { return context_; }

 private:
  GlContext() = default;
  friend class ContextFactory;

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  GpuDevice device_;
};

/// Makes a context current on this thread for as long as it lives, then puts back what was there.
class CurrentContext {
 public:
  explicit CurrentContext(const GlContext& context);
  ~CurrentContext();
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;

  /// Fails where the context is current on another thread.
  [[nodiscard]] Status status() const;

 private:
  EGLDisplay display_;
  EGLint error_ = EGL_SUCCESS;
  EGLenum previous_api_;
  EGLDisplay previous_display_;
  EGLContext previous_context_;
  EGLSurface previous_draw_, previous_read_;
};

}  // namespace swept
