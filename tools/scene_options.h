// Options that `swept render` and `swept info` share: what the command line wants otherwise than the file.
#pragma once

#include <memory>
#include <optional>

#include <CLI/App.hpp>
#include <Eigen/Core>

#include "splat/io/scene_file.h"

namespace swept {

/// Adds --points-scale and the options of the table of splat/fields.h to `command`; values out of range are
/// parse errors.
[[nodiscard]] std::shared_ptr<const SceneOverrides> add_scene_options(CLI::App& command);

/// --orthographic, --no-lens, --aperture and all else of CameraOverrides.
void add_camera_options(CLI::App& command, CameraOverrides& wanted);

/// --up: one of the six axes, or three numbers.
void add_up_option(CLI::App& command, std::optional<Eigen::Vector3d>& up, const char* help);

/// Prints `error` to stderr and returns the exit code that it stands for: 2 if it is about what the command
/// line said, else 1.
[[nodiscard]] int report_scene_error(const char* command, const Error& error,
                                     const SceneOverrides& overrides);

}  // namespace swept
