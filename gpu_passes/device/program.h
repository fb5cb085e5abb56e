// Shader programs from the embedded files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gpu_passes/device/gl_object.h"
#include "splat/result.h"

namespace swept {

/// A shader's text with its includes in place. `files` are the files by the source number that #line gives
/// them.
struct ShaderText {
  std::string text;
  std::vector<std::string> files;
};

/// `source` is the text of file `name`; includes are looked up among the embedded files, each taken once. The
/// error names the file that includes what is not there.
[[nodiscard]] Result<ShaderText> expand_includes(std::string_view name, std::string_view source);

/// A driver's log with "depth.frag:12:" where it says "0:12(5):" (Mesa), "0(12) :" (NVIDIA) or "0:12:".
[[nodiscard]] std::string name_files(std::string_view log, const std::vector<std::string>& files);

/// Compiles and links two embedded files, each after "#version 430 core" and a #define per word of `defines`.
/// Uniform block "Frame" is bound to 0. The error's file is the shader at fault, its reason starts with the
/// place. A context must be current.
[[nodiscard]] Result<GlProgram> build_program(std::string_view vertex, std::string_view fragment,
                                              const std::vector<std::string>& defines);

/// The same from given text, under the name that messages give it.
[[nodiscard]] Result<GlShader> compile_shader(GLenum stage, std::string_view name, std::string_view source,
                                              const std::vector<std::string>& defines);

}  // namespace swept
