// COLMAP's cameras.txt and images.txt.
//
// A camera is a line: ID MODEL WIDTH HEIGHT PARAMETER...; an image two: ID QW QX QY QZ TX TY TZ CAMERA NAME,
// world to camera in the axes of computer vision, and the points found in it, X Y ID each, or nothing.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include <Eigen/Geometry>

#include "splat/io/camera_file.h"
#include "splat/io/file_bytes.h"

namespace swept::io {
namespace {

/// The lines of a text, from the first on.
class Lines {
 public:
  Lines(const std::string& file, std::string_view text) : file_(file), text_(text) {}

  bool next() {
    if (text_.empty()) return false;
    const std::size_t end = std::min(text_.find('\n'), text_.size());
    line_ = text_.substr(0, end);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    ++number_;
    return true;
  }
  /// To the next line that is neither blank nor a comment.
  bool next_entry() {
    while (next()) {
      const std::size_t first = line_.find_first_not_of(" \t");
      if (first != std::string_view::npos && line_[first] != '#') return true;
    }
    return false;
  }
  [[nodiscard]] std::string place() const { return "line " + std::to_string(number_); }
  [[nodiscard]] Error fail(const std::string& reason) const { return {file_, place(), reason}; }

  /// The next word of the line; empty at its end.
  std::string_view word() {
    line_.remove_prefix(std::min(line_.find_first_not_of(" \t"), line_.size()));
    const std::string_view word = line_.substr(0, line_.find_first_of(" \t"));
    line_.remove_prefix(word.size());
    return word;
  }
  /// All that is left of the line but blanks around it.
  [[nodiscard]] std::string_view rest() const {
    const std::size_t first = line_.find_first_not_of(" \t");
    if (first == std::string_view::npos) return {};
    return line_.substr(first, line_.find_last_not_of(" \t") + 1 - first);
  }

 private:
  std::string file_;
  std::string_view text_, line_;
  std::size_t number_ = 0;
};

struct Model {
  std::string_view name;
  std::size_t focals, parameters;  ///< focal lengths come first, then cx and cy, then the distortion
  bool perspective;
};
constexpr Model models[] = {{"SIMPLE_PINHOLE", 1, 3, true},
                            {"PINHOLE", 2, 4, true},
                            {"SIMPLE_RADIAL", 1, 4, true},
                            {"RADIAL", 1, 5, true},
                            {"OPENCV", 2, 8, true},
                            {"FULL_OPENCV", 2, 12, true},
                            {"OPENCV_FISHEYE", 2, 8, false},
                            {"SIMPLE_RADIAL_FISHEYE", 1, 4, false},
                            {"RADIAL_FISHEYE", 1, 5, false},
                            {"FOV", 2, 5, false},
                            {"THIN_PRISM_FISHEYE", 2, 12, false}};

struct Camera {
  nlohmann::json intrinsics;
  int width, height;
  std::string_view bent;  ///< the model's name where the lens distorts; else empty
};

struct Picture {
  std::string name, place;
  Eigen::Matrix4d world_from_camera;
  const Camera* camera;
};

/// Numbers within names by what they count: image9 before image10.
bool natural_less(std::string_view a, std::string_view b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto take_number = [&](std::string_view& text) {
    std::size_t end = 0;
    while (end < text.size() && digit(text[end])) ++end;
    std::string_view number = text.substr(0, end);
    text.remove_prefix(end);
    number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
    return number;
  };
  while (!a.empty() && !b.empty()) {
    if (digit(a.front()) && digit(b.front())) {
      const std::string_view left = take_number(a), right = take_number(b);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
      continue;
    }
    if (a.front() != b.front()) return a.front() < b.front();
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  return a.size() < b.size();
}

std::optional<double> finite(std::string_view word) {
  const std::optional<double> number = parse_number(word);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

Result<std::map<std::string, Camera>> read_cameras(const std::string& path, const std::string& text) {
  std::map<std::string, Camera> cameras;
  Lines lines(path, text);
  while (lines.next_entry()) {
    const std::string id(lines.word());
    const std::string_view name = lines.word();
    const auto* const model = std::find_if(std::begin(models), std::end(models),
                                           [&](const Model& known) { return known.name == name; });
    if (model == std::end(models))
      return lines.fail("is no camera of COLMAP: there is no model \"" + std::string(name) + "\"");
    if (!model->perspective)
      return lines.fail("the camera is a " + std::string(name) + ", and only perspective cameras are known");
    std::vector<double> numbers;
    for (std::string_view word = lines.word(); !word.empty(); word = lines.word()) {
      const std::optional<double> number = finite(word);
      if (!number) return lines.fail(not_a_number(word));
      numbers.push_back(*number);
    }
    if (numbers.size() != model->parameters + 2)
      return lines.fail("a camera that is a " + std::string(name) + " has a width, a height and " +
                        std::to_string(model->parameters) + " parameters, found " +
                        std::to_string(numbers.size()) + " numbers");
    for (const double size : {numbers[0], numbers[1]})
      if (!(size >= 1.0 && size <= 65536.0 && size == std::floor(size)))
        return lines.fail("width and height must be whole numbers between 1 and 65536");
    const double* const own = numbers.data() + 2;
    const double focal_x = own[0], focal_y = own[model->focals - 1];
    if (!(focal_x > 0.0 && focal_y > 0.0)) return lines.fail("focal lengths must be above 0");
    Camera camera;
    camera.width = static_cast<int>(numbers[0]);
    camera.height = static_cast<int>(numbers[1]);
    camera.intrinsics = {{"width", numbers[0]}, {"height", numbers[1]},     {"fx", focal_x},
                         {"fy", focal_y},       {"cx", own[model->focals]}, {"cy", own[model->focals + 1]}};
    if (std::any_of(own + model->focals + 2, own + model->parameters, [](double d) { return d != 0.0; }))
      camera.bent = model->name;
    if (!cameras.emplace(id, std::move(camera)).second)
      return lines.fail("there is a camera " + id + " already");
  }
  return cameras;
}

Result<std::vector<Picture>> read_images(const std::string& path, const std::string& text,
                                         const std::map<std::string, Camera>& cameras) {
  std::vector<Picture> pictures;
  Lines lines(path, text);
  while (lines.next_entry()) {
    Picture picture;
    picture.place = lines.place();
    static_cast<void>(lines.word());
    std::array<double, 7> pose{};
    for (double& value : pose) {
      const std::string_view word = lines.word();
      const std::optional<double> number = finite(word);
      if (!number)
        return lines.fail(word.empty() ? "expected ID QW QX QY QZ TX TY TZ CAMERA NAME" : not_a_number(word));
      value = *number;
    }
    const std::string id(lines.word());
    const auto camera = cameras.find(id);
    if (camera == cameras.end())
      return lines.fail("the image's camera, \"" + id + "\", is not in cameras.txt");
    picture.camera = &camera->second;
    picture.name = lines.rest();
    const Eigen::Quaterniond given(pose[0], pose[1], pose[2], pose[3]);
    if (!(given.norm() > 1e-6 && given.norm() < 1e6)) return lines.fail("the quaternion is no rotation");
    const Eigen::Matrix3d world_from_camera = given.normalized().toRotationMatrix().transpose();
    picture.world_from_camera.setIdentity();
    picture.world_from_camera.topLeftCorner<3, 3>() = world_from_camera;
    picture.world_from_camera.topRightCorner<3, 1>() =
        -(world_from_camera * Eigen::Vector3d(pose[4], pose[5], pose[6]));
    pictures.push_back(std::move(picture));
    if (!lines.next()) break;
    std::size_t words = 0;
    while (!lines.word().empty()) ++words;
    if (words % 3 != 0)
      return lines.fail(
          "expected the points of the image before, X Y ID each; an image without points has an empty line "
          "here");
  }
  return pictures;
}

}  // namespace

Result<CameraFile> read_colmap(const std::string& cameras_path, const std::string& images_path) {
  const Result<std::string> cameras_text = read_bytes(cameras_path), images_text = read_bytes(images_path);
  if (!cameras_text) return cameras_text.error();
  if (!images_text) return images_text.error();
  const auto cameras = read_cameras(cameras_path, *cameras_text);
  if (!cameras) return cameras.error();
  auto pictures = read_images(images_path, *images_text, *cameras);
  if (!pictures) return pictures.error();
  if (pictures->empty()) return Error{images_path, "", "has no images"};
  // The order in the file is that in which COLMAP solved them.
  std::stable_sort(pictures->begin(), pictures->end(),
                   [](const Picture& a, const Picture& b) { return natural_less(a.name, b.name); });
  CameraFile file;
  file.camera["convention"] = "opencv";
  std::vector<std::string> bent;
  for (const Picture& picture : *pictures) {
    nlohmann::json matrix = nlohmann::json::array();
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column) matrix.push_back(picture.world_from_camera(row, column));
    file.places.push_back(picture.place);
    file.camera["keys"].push_back({{"frame", file.places.size()},
                                   {"matrix", std::move(matrix)},
                                   {"intrinsics", picture.camera->intrinsics}});
    if (const std::string name(picture.camera->bent);
        !name.empty() && std::find(bent.begin(), bent.end(), name) == bent.end())
      bent.push_back(name);
  }
  file.film = {pictures->front().camera->width, pictures->front().camera->height};
  file.notes.push_back(frames_note(pictures->size(), "images, in the order of their names,", images_path));
  for (const std::string& name : bent)
    file.notes.push_back("unread: the distortion of a " + name +
                         " lens; what is drawn is not bent as its pictures are");
  return file;
}

}  // namespace swept::io
