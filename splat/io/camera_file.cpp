#include "splat/io/camera_file.h"

#include <filesystem>

#include "splat/io/file_bytes.h"
#include "splat/io/guarded.h"
#include "splat/io/json_text.h"
#include "splat/io/scene_parsing.h"

namespace swept::io {
namespace {

namespace fs = std::filesystem;

Result<CameraFile> read_json_cameras(const std::string& path) {
  const Result<std::string> text = read_bytes(path);
  if (!text) return text.error();
  const Result<nlohmann::json> document = parse_json(path, *text);
  if (!document) return document.error();
  const JsonNode root(*document, path);
  if (!root.is_object()) root.fail("a file of cameras is one JSON object");
  if (root.find("camera_path")) return cameras_of_path(root, *document);
  return cameras_of_transforms(root, *document);
}

/// COLMAP has its cameras in two files of one folder, in text or not.
Result<CameraFile> read_folder(const std::string& path, const fs::path& folder) {
  std::error_code code;
  const fs::path cameras = folder / "cameras.txt", images = folder / "images.txt";
  if (fs::exists(cameras, code) && fs::exists(images, code))
    return read_colmap(cameras.string(), images.string());
  if (fs::exists(folder / "images.bin", code))
    return Error{
        path, "",
        "has COLMAP's cameras in binary; colmap model_converter --output_type TXT writes the text that "
        "is read"};
  if (fs::exists(folder / "transforms.json", code))
    return read_json_cameras((folder / "transforms.json").string());
  return Error{path, "", "has no cameras.txt and images.txt, nor a transforms.json", ErrorKind::not_found};
}

Result<CameraFile> read_any(const std::string& path, double fps) {
  std::error_code code;
  const fs::path file(path);
  if (fs::is_directory(file, code)) return read_folder(path, file);
  const std::string name = file.filename().string();
  if (name.ends_with(".txt") || name.ends_with(".bin")) {
    if (!fs::exists(file, code)) return Error{path, "", "cannot be opened for reading", ErrorKind::not_found};
    return read_folder(path, file.parent_path());
  }
  if (name.ends_with(".gltf") || name.ends_with(".glb")) return cameras_of_gltf(path, fps);
  return read_json_cameras(path);
}

}  // namespace

std::string CameraFile::field_of(const std::string& field) const {
  constexpr std::string_view keys = "/keys/";
  if (!field.starts_with(keys)) return field;
  const std::size_t end = std::min(field.find('/', keys.size()), field.size());
  const std::size_t key = std::stoul(field.substr(keys.size(), end - keys.size()));
  const std::string member = field.substr(end);
  constexpr std::string_view matrix = "/matrix";
  if (key >= places.size()) return field;
  if (!member.starts_with(matrix) || matrix_name.empty()) return places[key];
  return places[key] + '/' + matrix_name + member.substr(matrix.size());
}

std::string frames_note(std::size_t count, const std::string& what, const std::string& file) {
  return "assumed: the camera is at the " + std::to_string(count) + ' ' + what + " of " + file +
         ", from frame 1 on, and moves straight between them";
}

Result<CameraFile> read_camera_file(const std::string& path, double fps) {
  return guarded(path, [&]() -> Result<CameraFile> {
    Result<CameraFile> file = read_any(path, fps);
    if (!file) return file;
    try {
      const CameraTrack track = parse_camera(JsonNode(file->camera, path), Film());
      if (const Status valid = track.validate(); !valid) throw valid.error();
    } catch (const Error& error) {
      return Error{path, file->field_of(error.field), error.reason, in_a_file(error.kind)};
    }
    return file;
  });
}

}  // namespace swept::io
