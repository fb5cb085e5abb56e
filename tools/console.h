// What the commands say. Data goes to stdout by fmt::print, and main() sees to it that it arrives; all else
// goes to stderr by these.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace swept {

/// To stderr. That it cannot be written is no reason to lose a frame.
template <class... Args>
void log(fmt::format_string<Args...> format, Args&&... args) {
  const std::string text = fmt::format(format, std::forward<Args>(args)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

/// Ends the help of every command.
inline constexpr const char* exit_codes_help = "Exit codes: 0 done, 1 something failed, 2 bad arguments.";

/// Makes stdin, stdout and stderr safe to use whatever the caller left of them, and signals that end the
/// process take its unfinished files away first. Once, before anything is opened.
void prepare_console();

/// Whether all that was written to stdout arrived. Says so on stderr if not.
[[nodiscard]] bool finish_console();

}  // namespace swept
