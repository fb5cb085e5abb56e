// `swept completion`: what a shell needs to complete the command's words.
#pragma once

#include <string>

#include <CLI/App.hpp>

namespace swept {

/// A script for bash, or for zsh, that completes the subcommands of `app` and their options. Made from what
/// `app` knows, so that no option can be forgotten.
[[nodiscard]] std::string completion_script(const CLI::App& app, bool zsh);

/// Adds the subcommand to `app`, which must outlive the parsing.
void add_completion_command(CLI::App& app);

}  // namespace swept
