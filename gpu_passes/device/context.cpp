#include "gpu_passes/device/context.h"

#include <array>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <utility>

#include <epoxy/gl.h>

#include "gpu_passes/device/egl_library.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

constexpr const char* surfaceless_name = "surfaceless";

bool has_word(const char* list, std::string_view word) {
  std::string_view rest = list == nullptr ? "" : list;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == word) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

std::string egl_error_name(EGLint error) {
  switch (error) {
    case EGL_NOT_INITIALIZED:
      return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS:
      return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC:
      return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE:
      return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG:
      return "EGL_BAD_CONFIG";
    case EGL_BAD_MATCH:
      return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER:
      return "EGL_BAD_PARAMETER";
    case EGL_CONTEXT_LOST:
      return "EGL_CONTEXT_LOST";
    default:
      return "EGL error " + std::to_string(error);
  }
}

const char* client_extensions() { return eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS); }

/// An extension's function; null where the library lacks it. Not through libepoxy, which would end the
/// process.
template <class Function>
Function extension_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

std::vector<EGLDeviceEXT> egl_devices() {
  if (!has_word(client_extensions(), "EGL_EXT_platform_device")) return {};
  const auto query = extension_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  EGLint count = 0;
  if (query == nullptr || query(0, nullptr, &count) != EGL_TRUE || count <= 0) return {};
  std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
  if (query(count, devices.data(), &count) != EGL_TRUE) return {};
  devices.resize(static_cast<std::size_t>(count));
  return devices;
}

/// Whether the device is the processor itself.
bool is_software(EGLDeviceEXT device) {
  const auto query = extension_function<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  return query != nullptr && has_word(query(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
}

EGLDisplay platform_display(EGLenum platform, void* native) {
  const auto get = extension_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  return get == nullptr ? EGL_NO_DISPLAY : get(platform, native, nullptr);
}

bool has_surfaceless() { return has_word(client_extensions(), "EGL_MESA_platform_surfaceless"); }

/// An index; −1 if the text is none.
int parse_index(const std::string& text) {
  int index = -1;
  const char* end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data(), end, index);
  return code == std::errc() && rest == end ? index : -1;
}

}  // namespace

/// Makes contexts on displays, and keeps the thread's API as it was.
class ContextFactory {
 public:
  ContextFactory() : previous_api_(eglQueryAPI()) {}
  ~ContextFactory() { eglBindAPI(previous_api_); }
  ContextFactory(const ContextFactory&) = delete;
  ContextFactory& operator=(const ContextFactory&) = delete;

  /// The error's reason says what the device lacks.
  Result<GlContext> on_device(EGLDeviceEXT device, std::size_t index) {
    return on_display(platform_display(EGL_PLATFORM_DEVICE_EXT, device), std::to_string(index));
  }
  Result<GlContext> surfaceless() {
    return on_display(platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY), surfaceless_name);
  }

 private:
  static Error failed(const char* call) {
    return {"", "gpu", std::string(call) + " fails with " + egl_error_name(eglGetError()), ErrorKind::device};
  }

  Result<GlContext> on_display(EGLDisplay display, const std::string& id) {
    if (display == EGL_NO_DISPLAY) return failed("eglGetPlatformDisplayEXT");
    EGLint major = 0, minor = 0;
    if (eglInitialize(display, &major, &minor) != EGL_TRUE) return failed("eglInitialize");
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE)
      return Error{"", "gpu", "it has no desktop OpenGL", ErrorKind::device};
    const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
    // EGL 1.5 has the former, with the same numbers, and need not list it.
    const bool has_versions = major > 1 || minor >= 5 || has_word(extensions, "EGL_KHR_create_context");
    for (const auto& [needed, there] :
         {std::pair{"EGL_KHR_create_context", has_versions},
          std::pair{"EGL_KHR_surfaceless_context", has_word(extensions, "EGL_KHR_surfaceless_context")}})
      if (!there) return Error{"", "gpu", std::string("it lacks ") + needed, ErrorKind::device};

    EGLConfig config = nullptr;
    if (!has_word(extensions, "EGL_KHR_no_config_context")) {
      constexpr std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                             EGL_NONE};
      EGLint count = 0;
      if (eglChooseConfig(display, wanted.data(), &config, 1, &count) != EGL_TRUE || count < 1)
        return Error{"", "gpu", "it has no configuration for OpenGL", ErrorKind::device};
    }
    constexpr std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION_KHR,
                                               4,
                                               EGL_CONTEXT_MINOR_VERSION_KHR,
                                               3,
                                               EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
                                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
                                               EGL_NONE};
    GlContext made;
    made.display_ = display;
    made.context_ = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
    if (made.context_ == EGL_NO_CONTEXT)
      return Error{"", "gpu", "it has no OpenGL 4.3 core (" + egl_error_name(eglGetError()) + ")",
                   ErrorKind::device};
    const CurrentContext current(made);
    if (const Status status = current.status(); !status) return status.error();
    const auto text = [](GLenum name) {
      const auto* bytes = reinterpret_cast<const char*>(glGetString(name));
      return std::string(bytes == nullptr ? "" : bytes);
    };
    made.device_ = {id, text(GL_VENDOR), text(GL_RENDERER), text(GL_VERSION), ""};
    return made;
  }

  EGLenum previous_api_;
};

Result<GlContext> GlContext::create(const std::string& device) {
  if (Status status = find_libraries(egl_libraries()); !status) return status.error();
  std::string wanted = device, field = "gpu";
  if (wanted.empty()) {
    const char* variable = std::getenv("SWEPT_GPU");
    if (variable != nullptr && *variable != '\0') wanted = variable, field = "SWEPT_GPU";
  }
  ContextFactory factory;
  const std::vector<EGLDeviceEXT> devices = egl_devices();
  const auto because = [&](Error error) {
    return Error{"", field, "no context on " + wanted + ": " + error.reason, error.kind};
  };
  if (wanted == surfaceless_name) {
    if (!has_surfaceless()) return because({"", "", "EGL lacks EGL_MESA_platform_surfaceless"});
    Result<GlContext> made = factory.surfaceless();
    return made ? std::move(made) : because(made.error());
  }
  if (!wanted.empty()) {
    const int index = parse_index(wanted);
    if (index < 0 || static_cast<std::size_t>(index) >= devices.size())
      return Error{"", field,
                   "must be \"surfaceless\" or the index of one of the " + std::to_string(devices.size()) +
                       " EGL devices, not \"" + wanted + "\"",
                   ErrorKind::device};
    Result<GlContext> made =
        factory.on_device(devices[static_cast<std::size_t>(index)], static_cast<std::size_t>(index));
    return made ? std::move(made) : because(made.error());
  }

  std::string reasons;
  for (const bool software : {false, true})
    for (std::size_t i = 0; i < devices.size(); ++i) {
      if (is_software(devices[i]) != software) continue;
      Result<GlContext> made = factory.on_device(devices[i], i);
      if (made) return made;
      reasons += "; device " + std::to_string(i) + ": " + made.error().reason;
    }
  if (devices.empty()) reasons += "; EGL lists no devices";
  if (has_surfaceless()) {
    Result<GlContext> made = factory.surfaceless();
    if (made) return made;
    reasons += std::string("; surfaceless: ") + made.error().reason;
  } else {
    reasons += "; EGL lacks EGL_MESA_platform_surfaceless";
  }
  return Error{"", field, "no OpenGL 4.3 without a display" + reasons, ErrorKind::device};
}

GlContext::GlContext(GlContext&& other) noexcept
    : display_(other.display_),
      context_(std::exchange(other.context_, EGL_NO_CONTEXT)),
      device_(std::move(other.device_)) {}

GlContext& GlContext::operator=(GlContext&& other) noexcept {
  std::swap(display_, other.display_);
  std::swap(context_, other.context_);
  std::swap(device_, other.device_);
  return *this;
}

GlContext::~GlContext() {
  if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
}

CurrentContext::CurrentContext(const GlContext& context)
    : display_(context.display()),
      previous_api_(eglQueryAPI()),
      previous_display_(eglGetCurrentDisplay()),
      previous_context_(eglGetCurrentContext()),
      previous_draw_(eglGetCurrentSurface(EGL_DRAW)),
      previous_read_(eglGetCurrentSurface(EGL_READ)) {
  eglBindAPI(EGL_OPENGL_API);
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.handle()) != EGL_TRUE)
    error_ = eglGetError();
}

CurrentContext::~CurrentContext() {
  if (previous_context_ != EGL_NO_CONTEXT)
    eglMakeCurrent(previous_display_, previous_draw_, previous_read_, previous_context_);
  else
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglBindAPI(previous_api_);
}

Status CurrentContext::status() const {
  if (error_ == EGL_SUCCESS) return Done{};
  return Error{"", "gpu", "the context cannot be made current: " + egl_error_name(error_), ErrorKind::device};
}

Result<std::vector<GpuDevice>> list_gpus() {
  return without_throwing("for the list of GPUs", [&]() -> Result<std::vector<GpuDevice>> {
    if (Status status = find_libraries(egl_libraries()); !status) return status.error();
    std::vector<GpuDevice> list;
    const auto add = [&](const std::string& id, const Result<GlContext>& made) {
      if (made)
        list.push_back(made->device());
      else
        list.push_back({id, "", "", "", made.error().reason});
    };
    ContextFactory factory;
    const std::vector<EGLDeviceEXT> devices = egl_devices();
    for (std::size_t i = 0; i < devices.size(); ++i) add(std::to_string(i), factory.on_device(devices[i], i));
    if (has_surfaceless()) add(surfaceless_name, factory.surfaceless());
    return list;
  });
}

}  // namespace swept
