// `swept init`: a scene file to go on from.
#pragma once

#include <CLI/App.hpp>

namespace swept {

/// Adds the subcommand to `app`. When it is parsed, it runs and stores its exit code.
void add_init_command(CLI::App& app, int& exit_code);

}  // namespace swept
