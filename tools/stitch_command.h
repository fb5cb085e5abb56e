// `swept stitch`: crops of a frame, put together.
#pragma once

#include <CLI/App.hpp>

namespace swept {

/// Adds the command to `app`; running it sets `exit_code`.
void add_stitch_command(CLI::App& app, int& exit_code);

}  // namespace swept
