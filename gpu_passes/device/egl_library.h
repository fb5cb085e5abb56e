// Whether EGL and OpenGL are on this machine at all.
#pragma once

#include <string>
#include <vector>

#include "splat/result.h"

namespace swept {

/// One library, under any of these names.
using LibraryNames = std::vector<std::string>;

/// Fails, and names what is missing, where one of the libraries cannot be loaded. To be called before
/// anything that libepoxy resolves: it ends the process where it finds none.
[[nodiscard]] Status find_libraries(const std::vector<LibraryNames>& libraries);

/// The libraries that EGL and desktop OpenGL need.
[[nodiscard]] std::vector<LibraryNames> egl_libraries();

}  // namespace swept
