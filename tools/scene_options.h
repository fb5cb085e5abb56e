// Options that `swept render` and `swept info` share: what the command line wants otherwise than the file.
#pragma once

#include <memory>

#include <CLI/App.hpp>

#include "splat/io/scene_file.h"

namespace swept {

/// Adds --size, --crop, --shutter, --segments, --points-scale and the options of the image model to
/// `command`; values out of range are parse errors.
[[nodiscard]] std::shared_ptr<const SceneOverrides> add_scene_options(CLI::App& command);

/// Prints `error` to stderr and returns the exit code that it stands for: 2 if only the command line can be
/// at fault, else 1.
[[nodiscard]] int report_scene_error(const char* command, const Error& error);

}  // namespace swept
