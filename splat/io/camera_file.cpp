#include "splat/io/camera_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "splat/io/file_bytes.h"
#include "splat/io/guarded.h"
#include "splat/io/json_node.h"
#include "splat/io/json_text.h"
#include "splat/io/read_report.h"

namespace swept::io {
namespace {

/// A frame, and the file around it, which says what the frame does not.
struct Lens {
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
};

/// What a pinhole in the middle of square pixels cannot show is refused.
void check_pinhole(const Lens& lens) {
  // Half a pixel at the picture's edge.
  constexpr double most_px = 0.5;
  const auto width = lens.positive("w"), height = lens.positive("h");
  const auto focal_x = lens.positive("fl_x"), focal_y = lens.positive("fl_y");
  if (focal_x && focal_y) {
    const double edge = 0.5 * (height ? *height : 2.0 * *focal_y);
    if (!(std::abs(*focal_y / *focal_x - 1.0) * edge <= most_px))
      lens.find("fl_y")->fail("differs from fl_x, and pixels are square here");
  }
  const auto check_center = [&](const char* name, const char* size_name, std::optional<double> size) {
    const auto center = lens.find(name);
    if (!center) return;
    if (!size) center->fail(std::string("comes without ") + size_name);
    if (!(std::abs(center->number() - 0.5 * *size) <= most_px))
      center->fail(std::string("is not half of ") + size_name +
                   ", and the view's centre is the picture's here");
  };
  check_center("cx", "w", width);
  check_center("cy", "h", height);
  if (const auto model = lens.find("camera_model")) {
    const std::string name = model->string();
    if (name.find("FISHEYE") != std::string::npos || name.find("EQUIRECT") != std::string::npos)
      model->fail("only perspective cameras are known");
  }
}

nlohmann::json fov_of(const Lens& lens) {
  const auto degrees = [](const char* axis, double radians) {
    return nlohmann::json{{"axis", axis}, {"degrees", radians * 180.0 / std::numbers::pi}};
  };
  const auto width = lens.positive("w"), height = lens.positive("h");
  // Vertically where that can be told, so that a wider film sees more and not less.
  if (const auto focal = lens.positive(lens.find("fl_y") ? "fl_y" : "fl_x"); focal && height)
    return degrees("vertical", 2.0 * std::atan(0.5 * *height / *focal));
  if (const auto angle = lens.positive("camera_angle_y")) return degrees("vertical", *angle);
  if (const auto angle = lens.positive("camera_angle_x")) {
    if (width && height && *angle < std::numbers::pi)
      return degrees("vertical", 2.0 * std::atan(std::tan(0.5 * *angle) * *height / *width));
    return degrees("horizontal", *angle);
  }
  lens.frame.fail("no field of view: camera_angle_x, or fl_x and w and h, are missing");
}

/// Distortion, which a pinhole does not have.
void note_unread(const JsonNode& root, const JsonNode& frame, std::vector<std::string>& unread) {
  for (const char* name : {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"}) {
    const auto node = Lens{frame, root}.find(name);
    if (!node || node->number() == 0.0) continue;
    if (std::find(unread.begin(), unread.end(), name) == unread.end()) unread.emplace_back(name);
  }
}

CameraFile parse(const JsonNode& root, const nlohmann::json& document) {
  const JsonNode list = root.require("frames");
  const std::vector<JsonNode> frames = list.elements();
  if (frames.empty()) list.fail("there are no frames");
  CameraFile file;
  file.camera["convention"] = "opengl";
  std::vector<std::string> unread;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Lens lens{frames[i], root};
    static_cast<void>(frames[i].require("transform_matrix"));
    check_pinhole(lens);
    note_unread(root, frames[i], unread);
    file.camera["keys"].push_back(
        {{"frame", i + 1}, {"matrix", document["frames"][i]["transform_matrix"]}, {"fov", fov_of(lens)}});
  }
  const Lens first{frames.front(), root};
  if (first.find("w") && first.find("h"))
    file.film = {static_cast<int>(first.find("w")->integer(1, 65536)),
                 static_cast<int>(first.find("h")->integer(1, 65536))};
  file.notes.push_back("assumed: the camera is at the " + std::to_string(frames.size()) + " frames of " +
                       root.file() + ", from frame 1 on, and moves straight between them");
  if (!unread.empty()) file.notes.push_back("unread: distortion " + listed(unread) + " of the camera's lens");
  return file;
}

}  // namespace

Result<CameraFile> read_camera_file(const std::string& path) {
  return guarded(path, [&]() -> Result<CameraFile> {
    const Result<std::string> text = read_bytes(path);
    if (!text) return text.error();
    const Result<nlohmann::json> document = parse_json(path, *text);
    if (!document) return document.error();
    const JsonNode root(*document, path);
    if (!root.is_object()) root.fail("a file of cameras is one JSON object");
    return parse(root, *document);
  });
}

}  // namespace swept::io
