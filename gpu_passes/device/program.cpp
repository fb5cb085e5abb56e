#include "gpu_passes/device/program.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "gpu_passes/six_pass/shaders.h"

namespace swept {
namespace {

std::string line_directive(std::size_t line, std::size_t file) {
  return "#line " + std::to_string(line) + " " + std::to_string(file) + "\n";
}

Status append_expanded(std::string_view name, std::string_view source, ShaderText& out) {
  const std::size_t file = out.files.size();
  out.files.emplace_back(name);
  out.text += line_directive(1, file);
  constexpr std::string_view keyword = "#include \"";
  std::size_t line = 0;
  while (!source.empty()) {
    ++line;
    const std::size_t end = std::min(source.find('\n'), source.size() - 1);
    const std::string_view text = source.substr(0, end + 1);
    source.remove_prefix(end + 1);
    if (!text.starts_with(keyword)) {
      out.text += text;
      continue;
    }
    const std::string_view rest = text.substr(keyword.size());
    const std::string included(rest.substr(0, rest.find('"')));
    if (std::find(out.files.begin(), out.files.end(), included) == out.files.end()) {
      const std::string_view included_source = shader_source(included);
      if (included_source.empty())
        return Error{std::string(name), std::to_string(line), "includes " + included + ", which there is not",
                     ErrorKind::device};
      if (Status status = append_expanded(included, included_source, out); !status) return status;
    }
    out.text += line_directive(line + 1, file);
  }
  return Done{};
}

/// A line of a driver's log, taken apart at its place.
struct LogPlace {
  std::string_view before, after;
  std::size_t file = 0, line = 0;
};

/// Removes `prefix` from the front of `text` if it is there.
bool skip(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

bool skip_number(std::string_view& text, std::size_t& number) {
  const auto [rest, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (code != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
  return true;
}

/// "0:12(5):", "0(12) :" or "0:12:", after "ERROR: " or "WARNING: " or nothing.
std::optional<LogPlace> find_place(std::string_view text) {
  const std::string_view whole = text;
  LogPlace place;
  if (!skip(text, "ERROR: ")) skip(text, "WARNING: ");
  place.before = whole.substr(0, whole.size() - text.size());
  if (!skip_number(text, place.file)) return std::nullopt;
  const bool in_brackets = skip(text, "(");
  if (!in_brackets && !skip(text, ":")) return std::nullopt;
  if (!skip_number(text, place.line)) return std::nullopt;
  std::size_t column = 0;
  if (in_brackets ? !skip(text, ")") : skip(text, "(") && !(skip_number(text, column) && skip(text, ")")))
    return std::nullopt;
  skip(text, " ");
  if (!skip(text, ":")) return std::nullopt;
  place.after = text;
  return place;
}

template <class GetParameter, class GetLog>
std::string log_of(GLuint name, GetParameter get_parameter, GetLog get_log) {
  GLint length = 0;
  get_parameter(name, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
  get_log(name, length, nullptr, log.data());
  log.resize(log.find('\0') == std::string::npos ? log.size() : log.find('\0'));
  while (!log.empty() && log.back() == '\n') log.pop_back();
  return log.empty() ? "the driver says no more" : log;
}

}  // namespace

Result<ShaderText> expand_includes(std::string_view name, std::string_view source) {
  ShaderText out;
  if (Status status = append_expanded(name, source, out); !status) return status.error();
  return out;
}

std::string name_files(std::string_view log, const std::vector<std::string>& files) {
  std::string out;
  while (!log.empty()) {
    const std::size_t end = std::min(log.find('\n'), log.size() - 1);
    const std::string_view line = log.substr(0, end + 1);
    log.remove_prefix(end + 1);
    const std::optional<LogPlace> place = find_place(line);
    if (place && place->file < files.size()) {
      out += place->before;
      out += files[place->file] + ":" + std::to_string(place->line) + ":";
      out += place->after;
    } else {
      out += line;
    }
  }
  return out;
}

Result<GlShader> compile_shader(GLenum stage, std::string_view name, std::string_view source,
                                const std::vector<std::string>& defines) {
  const Result<ShaderText> expanded = expand_includes(name, source);
  if (!expanded) return expanded.error();
  std::string text = "#version 430 core\n";
  for (const std::string& word : defines) text += "#define " + word + "\n";
  text += expanded->text;
  GlShader shader = GlShader::make(stage);
  const char* pointer = text.c_str();
  glShaderSource(shader.name(), 1, &pointer, nullptr);
  glCompileShader(shader.name());
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  return Error{std::string(name), "",
               "does not compile: " +
                   name_files(log_of(shader.name(), glGetShaderiv, glGetShaderInfoLog), expanded->files),
               ErrorKind::device};
}

Result<GlProgram> build_program(std::string_view vertex, std::string_view fragment,
                                const std::vector<std::string>& defines) {
  const Result<GlShader> vertex_shader =
      compile_shader(GL_VERTEX_SHADER, vertex, shader_source(vertex), defines);
  if (!vertex_shader) return vertex_shader.error();
  const Result<GlShader> fragment_shader =
      compile_shader(GL_FRAGMENT_SHADER, fragment, shader_source(fragment), defines);
  if (!fragment_shader) return fragment_shader.error();
  GlProgram program = GlProgram::make();
  for (const GLuint shader : {vertex_shader->name(), fragment_shader->name()})
    glAttachShader(program.name(), shader);
  glLinkProgram(program.name());
  GLint linked = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE)
    return Error{std::string(fragment), "",
                 "does not link with " + std::string(vertex) + ": " +
                     log_of(program.name(), glGetProgramiv, glGetProgramInfoLog),
                 ErrorKind::device};
  for (const GLuint shader : {vertex_shader->name(), fragment_shader->name()})
    glDetachShader(program.name(), shader);
  const GLuint block = glGetUniformBlockIndex(program.name(), "Frame");
  if (block != GL_INVALID_INDEX) glUniformBlockBinding(program.name(), block, 0);
  return program;
}

}  // namespace swept
