// `swept compare`: two EXR files in, figures out.
#pragma once

#include <CLI/App.hpp>

namespace swept {

/// Adds the subcommand to `app`. When it has run, `exit_code` is 0, or 1 if a file could not be read or
/// written, the images cannot be compared, or the limit of --min-psnr is not met. Figures go to stdout,
/// errors to stderr. `exit_code` must outlive the parsing.
void add_compare_command(CLI::App& app, int& exit_code);

}  // namespace swept
