// transforms.json of nerfstudio and instant-ngp, and the paths that nerfstudio's viewer saves.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "splat/io/camera_file.h"
#include "splat/io/read_report.h"

namespace swept::io {
namespace {

using Json = nlohmann::json;

/// A frame, and the file around it, which says what the frame does not.
struct Source {
  const JsonNode& frame;
  const JsonNode& root;

  [[nodiscard]] std::optional<JsonNode> find(const char* name) const {
    auto own = frame.find(name);
    return own ? own : root.find(name);
  }
  [[nodiscard]] std::optional<double> positive(const char* name) const {
    const auto node = find(name);
    return node ? std::optional<double>(node->positive()) : std::nullopt;
  }
  /// Radians, of a whole field of view.
  [[nodiscard]] std::optional<double> angle(const char* name) const {
    const auto node = find(name);
    if (!node) return std::nullopt;
    if (!(node->positive() < std::numbers::pi)) node->fail("must be below pi");
    return node->number();
  }
};

Json fov(const char* axis, double radians) {
  return {{"fov", {{"axis", axis}, {"degrees", radians * 180.0 / std::numbers::pi}}}};
}

/// "fov" where the picture's middle and one angle say all, else "intrinsics".
Json view_of(const Source& source) {
  const auto width = source.positive("w"), height = source.positive("h");
  const auto angle_x = source.angle("camera_angle_x"), angle_y = source.angle("camera_angle_y");
  std::optional<double> focal_x = source.positive("fl_x"), focal_y = source.positive("fl_y");
  if (!focal_x && angle_x && width) focal_x = 0.5 * *width / std::tan(0.5 * *angle_x);
  if (!focal_y && angle_y && height) focal_y = 0.5 * *height / std::tan(0.5 * *angle_y);
  if (!focal_x) focal_x = focal_y;
  if (!focal_y) focal_y = focal_x;
  for (const auto& [center, size] : {std::pair{"cx", "w"}, {"cy", "h"}})
    if (const auto node = source.find(center); node && !source.find(size))
      node->fail(std::string("comes without ") + size);
  if (focal_x && width && height) {
    Json view = {{"width", *width}, {"height", *height}, {"fx", *focal_x}, {"fy", *focal_y}};
    for (const char* center : {"cx", "cy"})
      if (const auto node = source.find(center)) view[center] = node->number();
    return {{"intrinsics", view}};
  }
  // Vertically where that can be told, so that a wider film sees more and not less.
  if (focal_y && height) return fov("vertical", 2.0 * std::atan(0.5 * *height / *focal_y));
  if (angle_y) return fov("vertical", *angle_y);
  if (angle_x) return fov("horizontal", *angle_x);
  source.frame.fail("no field of view: camera_angle_x, or fl_x and w and h, are missing");
}

/// Distortion, which a pinhole does not have.
void note_unread(const Source& source, std::vector<std::string>& unread) {
  for (const char* name : {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"}) {
    const auto node = source.find(name);
    if (!node || node->number() == 0.0) continue;
    if (std::find(unread.begin(), unread.end(), name) == unread.end()) unread.emplace_back(name);
  }
}

void check_model(const Source& source, const char* name) {
  const auto model = source.find(name);
  if (!model) return;
  std::string text = model->string();
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  for (const char* other : {"FISHEYE", "EQUIRECT", "ORTHO", "OMNI", "VR180"})
    if (text.find(other) != std::string::npos) model->fail("only perspective cameras are known");
}

std::vector<JsonNode> frames_of(const JsonNode& list) {
  std::vector<JsonNode> frames = list.elements();
  if (frames.empty()) list.fail("there are no frames");
  return frames;
}

std::optional<std::pair<int, int>> film_of(const std::optional<JsonNode>& width,
                                           const std::optional<JsonNode>& height) {
  if (!width || !height) return std::nullopt;
  return std::pair{static_cast<int>(width->integer(1, 65536)), static_cast<int>(height->integer(1, 65536))};
}

}  // namespace

CameraFile cameras_of_transforms(const JsonNode& root, const Json& document) {
  const std::vector<JsonNode> frames = frames_of(root.require("frames"));
  CameraFile file;
  file.matrix_name = "transform_matrix";
  file.camera["convention"] = "opengl";
  std::vector<std::string> unread;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Source source{frames[i], root};
    static_cast<void>(frames[i].require("transform_matrix"));
    check_model(source, "camera_model");
    note_unread(source, unread);
    Json key = view_of(source);
    key["frame"] = i + 1;
    key["matrix"] = document["frames"][i]["transform_matrix"];
    file.camera["keys"].push_back(std::move(key));
    file.places.push_back("/frames/" + std::to_string(i));
  }
  const Source first{frames.front(), root};
  file.film = film_of(first.find("w"), first.find("h"));
  file.notes.push_back(frames_note(frames.size(), "frames", root.file()));
  if (!unread.empty()) file.notes.push_back("unread: distortion " + listed(unread) + " of the camera's lens");
  return file;
}

CameraFile cameras_of_path(const JsonNode& root, const Json& document) {
  const std::vector<JsonNode> frames = frames_of(root.require("camera_path"));
  CameraFile file;
  file.matrix_name = "camera_to_world";
  file.camera["convention"] = "opengl";
  check_model({root, root}, "camera_type");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    static_cast<void>(frames[i].require("camera_to_world"));
    const JsonNode degrees = frames[i].require("fov");
    if (!(degrees.positive() < 180.0)) degrees.fail("must be below 180");
    file.camera["keys"].push_back({{"frame", i + 1},
                                   {"matrix", document["camera_path"][i]["camera_to_world"]},
                                   {"fov", {{"axis", "vertical"}, {"degrees", degrees.number()}}}});
    file.places.push_back("/camera_path/" + std::to_string(i));
  }
  file.film = film_of(root.find("render_width"), root.find("render_height"));
  file.notes.push_back(frames_note(frames.size(), "frames", root.file()));
  for (const char* name : {"fps", "seconds"})
    if (root.find(name)) file.notes.push_back(std::string("unread: ") + name + " of the camera's path");
  return file;
}

}  // namespace swept::io
