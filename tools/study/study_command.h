// swept study: how wrong every method is, and how long it takes.
#pragma once

#include <CLI/App.hpp>

namespace swept {

void add_study_command(CLI::App& app, int& exit_code);

}  // namespace swept
