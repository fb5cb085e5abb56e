// `swept info`: what is in a scene file, and what it resolves to at a frame.
#pragma once

#include <CLI/App.hpp>

namespace swept {

/// Adds the subcommand to `app`. When it has run, `exit_code` is 0, or 1 if the scene could not be read. The
/// report goes to stdout. `exit_code` must outlive the parsing.
void add_info_command(CLI::App& app, int& exit_code);

}  // namespace swept
