#include "splat/io/cloud_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "splat/io/camera_file.h"
#include "splat/io/empty_files.h"
#include "splat/io/frame_points.h"
#include "splat/io/guarded.h"
#include "splat/io/obj_materials.h"
#include "splat/io/point_file.h"
#include "splat/io/sequence.h"
#include "splat/io/splat_file.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

constexpr double fov_y_degrees = 40.0;
constexpr std::size_t most_files = 5, most_points = 1'000'000;

bool is_sequence(const std::string& path) {
  std::error_code code;
  return is_sequence_pattern(path) && !std::filesystem::exists(path, code);
}

/// What was looked at to frame the points and to see what they come with.
struct Sample {
  std::vector<Eigen::Vector3d> points;
  std::vector<float> reaches;
  bool colors = false, gaussians = false;
  std::vector<std::string> properties;  ///< of the first file, read or not
  std::size_t dropped = 0;
  double white = 0.0;        ///< the stored intensity to show as white, if intensities are shown
  bool flat = false;         ///< there are intensities, and they hardly differ
  std::vector<int> numbers;  ///< of the files of a sequence that were looked at
  int first = 0;             ///< number in the sequence
};

/// Stored intensities.
struct Brightness {
  double white =
      0.0;  ///< nearly the brightest: few scans use all of their range, and some points outshine all
  bool flat = false;  ///< most are so near each other that a picture of them shows noise
};

Result<Brightness> brightness_of(const std::string& path, bool skip_invalid) {
  ReadOptions as_stored;
  as_stored.skip_invalid = skip_invalid;
  as_stored.color_range = 1.0;
  as_stored.color_space = ColorSpace::linear;
  Result<PointSet> set = read_points(path, as_stored);
  if (!set) return set.error();
  if (set->color.empty()) return Brightness{};
  const auto percentile = [&](std::size_t percent) {
    const auto rank = set->color.begin() +
                      static_cast<std::ptrdiff_t>(set->size() - 1 - set->size() * (100 - percent) / 100);
    std::nth_element(set->color.begin(), rank, set->color.end(),
                     [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a.x() < b.x(); });
    return static_cast<double>(rank->x());
  };
  const double white = percentile(98);
  return Brightness{white, percentile(90) - percentile(10) < 0.25 * white};
}

/// Of trained splats; those that hardly show are no reason to stand far away, unless there are no others.
Status look_at_splats(const std::string& path, bool skip_invalid, Sample& sample) {
  SplatReadOptions options;
  options.skip_invalid = skip_invalid;
  options.motion = true;
  const Result<LoadedSplats> loaded = read_splats(path, options);
  if (!loaded) return loaded.error();
  const SplatCloud& splats = loaded->splats;
  constexpr float seen = 0.1f;
  const std::size_t step = (splats.size() + most_points - 1) / most_points;
  const std::size_t before = sample.points.size();
  for (const float least : {seen, 0.0f}) {
    if (sample.points.size() > before) break;
    for (std::size_t i = 0; i < splats.size(); i += step)
      if (splats.opacity[i] >= least) sample.points.push_back(splats.position[i]);
  }
  sample.dropped += loaded->report.dropped;
  sample.colors = sample.gaussians = true;
  sample.properties = loaded->report.unread;
  return Done{};
}

Status look_at(const std::string& path, bool skip_invalid, Sample& sample) {
  ReadOptions options;
  options.skip_invalid = skip_invalid;
  const Result<PointSet> set = read_points(path, options);
  if (!set) return set.error();
  const std::size_t step = (set->size() + most_points - 1) / most_points;
  for (std::size_t i = 0; i < set->size(); i += step) {
    sample.points.push_back(set->position[i]);
    if (!set->radius.empty()) sample.reaches.push_back(set->radius[i]);
    if (!set->axis_u.empty())
      sample.reaches.push_back(std::max(set->axis_u[i].norm(), set->axis_v[i].norm()));
  }
  sample.dropped += set->report.dropped;
  if (!sample.properties.empty()) return Done{};
  sample.colors = !set->color.empty();
  sample.gaussians = !set->axis_u.empty();
  if (sample.colors && !set->report.properties_of("intensity").empty()) {
    const Result<Brightness> brightness = brightness_of(path, skip_invalid);
    if (!brightness) return brightness.error();
    sample.flat = brightness->flat;
    sample.colors = !sample.flat;
    sample.white = sample.flat ? 0.0 : brightness->white;
  }
  sample.properties = set->report.unread;
  for (const ReadReport::Use& use : set->report.used)
    sample.properties.insert(sample.properties.end(), use.properties.begin(), use.properties.end());
  return Done{};
}

/// Files evenly from the first to the last. Points that are not finite are dropped from files that stand
/// alone.
Result<Sample> sample_of(const std::string& path, std::optional<DrawAs> draw) {
  Sample sample;
  if (!is_sequence(path)) {
    if (draw == DrawAs::splats || (!draw && holds_splats(path))) {
      if (const Status status = look_at_splats(path, true, sample); !status) return status.error();
      return sample;
    }
    if (const Status status = look_at(path, true, sample); !status) return status.error();
    return sample;
  }
  const Result<std::vector<NumberedFile>> files = list_sequence(path);
  if (!files) return files.error();
  const bool splats = draw == DrawAs::splats || (!draw && holds_splats(files->front().path));
  const auto look = [&](const NumberedFile& file) {
    return splats ? look_at_splats(file.path, false, sample) : look_at(file.path, false, sample);
  };
  const std::size_t looks = std::min(files->size(), most_files);
  for (std::size_t i = 0; i < looks; ++i) {
    const NumberedFile& file = (*files)[looks == 1 ? 0 : i * (files->size() - 1) / (looks - 1)];
    const Status status = look(file);
    if (!status && status.error().kind == ErrorKind::empty) continue;
    if (!status) return status.error();
    sample.numbers.push_back(file.number);
  }
  // Those that are spread evenly may have missed the few that have points.
  for (const NumberedFile& file : *files) {
    if (!sample.numbers.empty()) break;
    const Status status = look(file);
    if (status) sample.numbers.push_back(file.number);
    if (!status && status.error().kind != ErrorKind::empty) return status.error();
  }
  if (sample.numbers.empty()) return Error{path, "", "none of its files has points"};
  sample.first = files->front().number;
  return sample;
}

/// Which program wrote a PLY file, as far as that says which axis is up there.
std::string writer_of(const std::string& path) {
  std::string head(4096, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  head.resize(std::min(head.size(), head.find("end_header")));
  for (const char* writer : {"Blender", "CloudCompare"})
    if (head.starts_with("ply") && head.find(writer) != std::string::npos) return writer;
  return {};
}

bool has_any(const Sample& sample, std::initializer_list<std::string_view> names) {
  return std::any_of(sample.properties.begin(), sample.properties.end(), [&](std::string property) {
    for (char& c : property)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return std::find(names.begin(), names.end(), property) != names.end();
  });
}

struct Convention {
  io::Front front;
  std::string why;  ///< "y up, …"
};

/// Seen level with a wanted up, from where its nearest axis is seen from.
io::Front front_of(const Eigen::Vector3d& wanted) {
  const Eigen::Vector3d up = wanted.stableNormalized();
  Eigen::Index axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  Eigen::Vector3d forward(0, axis == 2 ? 1 : 0, axis == 2 ? 0 : up[axis] > 0.0 ? -1 : 1);
  forward = (forward - forward.dot(up) * up).normalized();
  return {up, forward, 15.0, 20.0};
}

Convention convention_of(const std::string& file, const Sample& sample,
                         const std::optional<Eigen::Vector3d>& up) {
  if (up)
    return {front_of(*up), "up " + shortest_text(up->x()) + ' ' + shortest_text(up->y()) + ' ' +
                               shortest_text(up->z()) + ", as asked"};
  // Trained in the axes of computer vision: y down, z forward.
  if (sample.gaussians) return {{{0, -1, 0}, {0, 0, 1}, 10.0, 0.0}, "y down, as Gaussian splats are trained"};
  std::string reason;
  const std::string writer = writer_of(file), extension = std::filesystem::path(file).extension().string();
  Eigen::Vector3d low = sample.points.front(), high = low;
  for (const Eigen::Vector3d& p : sample.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // Metres of a national grid: far from their origin by much more than they are wide.
  const double away = low.cwiseMax(-high).head<2>().maxCoeff();
  if (!writer.empty())
    reason = "as " + writer + " writes files";
  else if (extension == ".pcd" || extension == ".PCD")
    reason = "as robots have it";
  else if (has_any(sample, {"ring", "reflectivity", "reflectance", "easting", "gps_time", "gpstime",
                            "return_number", "classification", "scan_angle"}))
    reason = "as scanners have it";
  else if (away > 1e4 && away > 3.0 * (high - low).head<2>().maxCoeff())
    reason = "as surveys have it, for the points are far from their origin";
  if (reason.empty()) return {{{0, 1, 0}, {0, 0, -1}, 15.0, 20.0}, "y up, which the file does not say"};
  // Ground is seen from higher up.
  const Eigen::Vector3d size = high - low;
  const bool flat = size.z() < 0.3 * std::max(size.x(), size.y());
  return {{{0, 0, 1}, {0, 1, 0}, flat ? 40.0 : 20.0, 20.0}, "z up, " + reason};
}

/// What is set for a side of the film, or what stands in for it and for what is out of its range.
double length_or(const SceneOverrides& overrides, const char* pointer, double otherwise) {
  const auto found = overrides.fields.find(pointer);
  if (found == overrides.fields.end() || !find_field(pointer)->legal(found->second)) return otherwise;
  return found->second.front();
}

std::string defaults_line(const SceneOverrides& overrides) {
  std::string line;
  const auto add = [&](const char* pointer, const char* text) {
    if (overrides.fields.contains(pointer)) return;
    line += (line.empty() ? "" : ", ") + std::string(text);
  };
  add("/film/width", "1920 x 1080 px");
  add("/fps", "24 frames per second");
  add("/shutter/open", "shutter open from -0.25 to 0.25 frames");
  return line.empty() ? line : "assumed: " + line;
}

/// How a scene file in `folder` names the points.
std::string path_from(const std::string& folder, const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path name = fs::path(path).filename();
  const fs::path from = fs::weakly_canonical(fs::absolute(folder.empty() ? "." : folder));
  const fs::path there = fs::weakly_canonical(fs::absolute(fs::path(path)).parent_path());
  const fs::path relative = (there / name).lexically_relative(from);
  if (relative.empty() || *relative.begin() == "..") return (there / name).string();
  return relative.string();
}

std::string text_of(const Sample& sample, const std::string& path, const std::string& folder,
                    const io::Framing& framing, const Eigen::Vector3d& up, double width, double height) {
  const auto vector = [](const Eigen::Vector3d& v) { return Json{v.x(), v.y(), v.z()}; };
  Json source;
  source[sample.numbers.empty() ? "file" : "sequence"] = path_from(folder, path);
  if (sample.dropped > 0) source["skip_invalid"] = true;
  if (sample.white > 0.0) source["color_range"] = sample.white;
  if (sample.flat) source["attributes"] = {{"intensity", ""}};
  Json object = {{"name", std::filesystem::path(path).filename().string()}, {"source", source}};
  // Of estimated normals the side that is seen.
  if (!sample.colors) object["color"] = {{"normals", vector(framing.back)}};
  const int frame = sample.numbers.empty() ? 1 : sample.first;
  // A power of ten, a thousandth of the distance or less.
  const double near = std::pow(10.0, std::floor(std::log10(framing.distance)) - 3.0);
  Json scene = {
      {"swept", 1},
      {"film", {{"width", static_cast<int>(width)}, {"height", static_cast<int>(height)}}},
      {"fps", 24},
      {"frame", frame},
      {"shutter", {{"open", -0.25}, {"close", 0.25}}},
      {"camera",
       {{"fov", {{"axis", "vertical"}, {"degrees", fov_y_degrees}}},
        {"near", near},
        {"keys",
         Json::array(
             {{{"eye", vector(framing.eye)}, {"target", vector(framing.target)}, {"up", vector(up)}}})}}},
      {"objects", Json::array({object})}};
  try {
    return scene.dump(2) + '\n';
  } catch (const Json::type_error&) {
    throw Error{path, "", "its name, or that of a folder on the way to it, is not UTF-8, as scene files are"};
  }
}

Result<CloudScene> make_scene(const std::string& path, const std::string& folder,
                              const SceneOverrides& overrides) {
  if (overrides.up && (!overrides.up->allFinite() || overrides.up->isZero(0.0)))
    return Error{path, "up", "the up vector must be finite and not zero", ErrorKind::argument};
  Result<Sample> sample = sample_of(path, overrides.draw);
  if (!sample) return sample.error();
  // A texture is colour enough.
  if (!overrides.texture.empty()) sample->colors = true;
  std::string file = path;
  if (!sample->numbers.empty()) {
    Result<std::string> first = find_in_sequence(path, sample->first);
    if (!first) return first.error();
    file = std::move(*first);
  }
  // So are materials.
  if (overrides.draw == DrawAs::triangles && !io::files_of_obj_materials(file).empty()) sample->colors = true;
  const Convention convention = convention_of(file, *sample, overrides.up);
  const double width = length_or(overrides, "/film/width", 1920.0),
               height = length_or(overrides, "/film/height", 1080.0);
  const double tan_y = std::tan(0.5 * fov_y_degrees * std::numbers::pi / 180.0);
  // A few huge discs are no reason to stand far away.
  std::vector<float> reaches = sample->reaches;
  double reach = 0.0;
  if (!reaches.empty() && !sample->gaussians) {
    const auto middle = reaches.begin() + static_cast<std::ptrdiff_t>(reaches.size() / 2);
    std::nth_element(reaches.begin(), middle, reaches.end());
    reach = *middle;
  }
  const io::Front& front = convention.front;
  const Result<io::Framing> framing =
      io::frame_points(sample->points, reach, front, tan_y * width / height, tan_y);
  if (!framing)
    return Error{path, framing.error().field, framing.error().reason, in_a_file(framing.error().kind)};

  CloudScene scene;
  scene.text = text_of(*sample, path, folder, *framing, front.up, width, height);
  if (overrides.camera_file.empty())
    scene.assumed.push_back("assumed: seen from the front and " + shortest_text(front.above_degrees) +
                            " degrees above, " + convention.why);
  std::string frame = "assumed: framed by the points";
  if (!sample->numbers.empty()) {
    frame += sample->numbers.size() == 1 ? " of file" : " of files";
    for (std::size_t i = 0; i < sample->numbers.size(); ++i)
      frame += (i > 0 ? ", " : " ") + std::to_string(sample->numbers[i]);
  }
  if (framing->far > 0)
    frame += ", but for " + std::to_string(framing->far) + " of " + std::to_string(sample->points.size()) +
             " that are far from the rest";
  if (overrides.camera_file.empty()) scene.assumed.push_back(std::move(frame));
  if (std::string line = defaults_line(overrides); !line.empty()) scene.assumed.push_back(std::move(line));
  if (!sample->colors)
    scene.assumed.push_back(sample->flat ? "assumed: coloured by normals, for the intensities hardly differ"
                                         : "assumed: coloured by normals, for there are no colours");
  if (sample->white > 0.0)
    scene.assumed.push_back("assumed: an intensity of " + shortest_text(sample->white) +
                            " is white, which 98% of the points do not exceed");
  if (sample->dropped > 0)
    scene.assumed.push_back("assumed: points that are not finite are left out, " +
                            std::to_string(sample->dropped) + " of them");
  return scene;
}

}  // namespace

Result<CloudScene> scene_of_points(const std::string& path, const std::string& folder,
                                   const SceneOverrides& overrides) {
  return io::guarded(path, [&] { return make_scene(path, folder, overrides); });
}

Result<SceneFile> read_scene_or_points(const std::string& path, const SceneOverrides& overrides) {
  if (!is_point_file_name(path) && !is_splat_file_name(path)) return read_scene_file(path, overrides);
  return io::guarded(path, [&]() -> Result<SceneFile> {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    SceneOverrides wanted = overrides;
    if (!overrides.camera_file.empty() && !overrides.fields.contains("/film/width")) {
      const Result<io::CameraFile> camera = io::read_camera_file(overrides.camera_file);
      if (!camera) return camera.error();
      if (camera->film) {
        wanted.fields["/film/width"] = {static_cast<double>(camera->film->first)};
        wanted.fields["/film/height"] = {static_cast<double>(camera->film->second)};
      }
    }
    Result<CloudScene> scene = scene_of_points(path, folder, wanted);
    if (!scene) return scene.error();
    return scene_from_text(scene->text, path, wanted, std::move(scene->assumed));
  });
}

}  // namespace swept
