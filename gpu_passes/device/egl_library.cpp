#include "gpu_passes/device/egl_library.h"

#include <algorithm>

#include <dlfcn.h>

namespace swept {
namespace {

bool loads(const std::string& name) {
  void* handle = dlopen(name.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (handle == nullptr) return false;
  dlclose(handle);
  return true;
}

}  // namespace

Status find_libraries(const std::vector<LibraryNames>& libraries) {
  for (const LibraryNames& names : libraries) {
    if (std::any_of(names.begin(), names.end(), loads)) continue;
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : " or ") + name;
    return Error{"", "gpu", "the GPU modes need " + list + ", which cannot be loaded here",
                 ErrorKind::device};
  }
  return Done{};
}

std::vector<LibraryNames> egl_libraries() { return {{"libEGL.so.1"}, {"libOpenGL.so.0", "libGL.so.1"}}; }

}  // namespace swept
