// Shader text, embedded at build.
#pragma once

#include <string_view>

namespace swept {

/// The text of a shader file of this folder, e.g. "depth.frag"; empty if there is none of that name.
[[nodiscard]] std::string_view shader_source(std::string_view name);

}  // namespace swept
