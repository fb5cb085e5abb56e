// Cameras of other tools, as the "camera" of a scene file. Private to splat/io.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "splat/io/json_node.h"
#include "splat/result.h"

namespace swept::io {

struct CameraFile {
  nlohmann::json camera;            ///< for parse_camera(), a key for each of the file's frames, from 1
  std::vector<std::string> places;  ///< of the keys, for errors: "/frames/3", "images.txt, line 7"
  std::string matrix_name;          ///< of a key's matrix there; empty: it has none
  std::optional<std::pair<int, int>> film;  ///< width and height, px, if the file says
  std::vector<std::string> notes;
  bool gltf_axes = false;  ///< its world is that of a glTF file

  /// The field of an error of parse_camera() or CameraTrack::validate(), as the file itself has it.
  [[nodiscard]] std::string field_of(const std::string& field) const;
};

/// Reads cameras by what the file is:
///   transforms.json     of nerfstudio and instant-ngp
///   camera paths        of nerfstudio's viewer
///   .gltf, .glb         the scene's first camera, and the animation of its node and those above it
///   COLMAP's text       a folder of cameras.txt and images.txt, or either of the two
/// Cameras of all of them are valid. Errors: another file; fish eyes and panoramas. Perspective cameras whose
/// lens distorts are taken without, with a note. `fps` makes frames of seconds.
[[nodiscard]] Result<CameraFile> read_camera_file(const std::string& path, double fps = 24.0);

// One function for each kind of file; those of JSON and glTF throw swept::Error.
[[nodiscard]] CameraFile cameras_of_transforms(const JsonNode& root, const nlohmann::json& document);
[[nodiscard]] CameraFile cameras_of_path(const JsonNode& root, const nlohmann::json& document);
[[nodiscard]] CameraFile cameras_of_gltf(const std::string& path, double fps);
[[nodiscard]] Result<CameraFile> read_colmap(const std::string& cameras_path, const std::string& images_path);

/// "assumed: the camera is at the 12 frames of FILE, from frame 1 on, and moves straight between them".
[[nodiscard]] std::string frames_note(std::size_t count, const std::string& what, const std::string& file);

}  // namespace swept::io
