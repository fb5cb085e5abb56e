// Cameras of other tools, as the "camera" of a scene file. Private to splat/io.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "splat/result.h"

namespace swept::io {

struct CameraFile {
  nlohmann::json camera;  ///< for parse_camera(), a key for each of the file's frames, from 1
  std::optional<std::pair<int, int>> film;  ///< width and height, px, if the file says
  std::vector<std::string> notes;
};

/// Reads transforms.json of nerfstudio and instant-ngp: camera-to-world matrices in OpenGL's axes, and one
/// focal length. Errors: another file, pixels that are not square or a centre that is not the picture's by
/// more than half a pixel, fish eyes and panoramas.
[[nodiscard]] Result<CameraFile> read_camera_file(const std::string& path);

}  // namespace swept::io
