// `swept render`: a scene file in, EXR frames out.
#pragma once

#include <CLI/App.hpp>

namespace swept {

/// Adds the subcommand to `app`. When it has run, `exit_code` is 0, 1 if reading, rendering or writing
/// failed, or 2 if the arguments do not fit each other. Logs go to stderr, the plan of --dry-run to stdout.
/// `exit_code` must outlive the parsing.
void add_render_command(CLI::App& app, int& exit_code);

}  // namespace swept
