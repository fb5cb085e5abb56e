#include "splat/io/scene_file.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <utility>

#include "splat/io/json_text.h"
#include "splat/io/scene_parsing.h"

namespace swept {
namespace {

using io::JsonNode;

constexpr long long format_version = 1;

Result<std::string> read_text(const std::string& path) {
  // 100,000 camera keys with matrices take 40 MB; what is larger is not a scene file.
  constexpr std::size_t max_bytes = std::size_t{256} << 20;
  std::error_code code;
  if (std::filesystem::is_directory(path, code)) return Error{path, "", "is a folder, not a scene file"};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path, "", "cannot open the scene file"};
  std::string text;
  std::array<char, 1 << 16> block;
  while (file.read(block.data(), block.size()), file.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
    if (text.size() > max_bytes) return Error{path, "", "too large for a scene file (256 MiB at most)"};
  }
  if (file.bad()) return Error{path, "", "cannot read the scene file"};
  return text;
}

Film parse_film(const JsonNode& node) {
  node.expect_keys({"width", "height"});
  Film film;
  film.width = static_cast<int>(node.require("width").integer(1, 65536));
  film.height = static_cast<int>(node.require("height").integer(1, 65536));
  return film;
}

/// [numerator, denominator], or one whole number.
FrameRate parse_fps(const JsonNode& node) {
  constexpr long long most = 1'000'000'000;
  if (node.is_number()) return {static_cast<int>(node.integer(1, most)), 1};
  (void)node.numbers(2);
  const std::vector<JsonNode> terms = node.elements();
  return {static_cast<int>(terms[0].integer(1, most)), static_cast<int>(terms[1].integer(1, most))};
}

Shutter parse_shutter(const JsonNode& node) {
  node.expect_keys({"open", "close"});
  Shutter shutter{node.require("open").number(), node.require("close").number()};
  if (shutter.close < shutter.open) node.fail("the shutter closes before it opens");
  return shutter;
}

Eigen::Vector4f parse_background(const JsonNode& node) {
  const bool with_alpha = node.is_array() && node.json().size() == 4;
  const std::vector<double> values = node.numbers(with_alpha ? 4 : 3);
  const Eigen::Vector4d background(values[0], values[1], values[2], with_alpha ? values[3] : 1.0);
  if (!(background.w() >= 0.0 && background.w() <= 1.0)) node.fail("the alpha must be between 0 and 1");
  if (!background.cast<float>().allFinite()) node.fail("too large for single precision");
  return background.cast<float>();
}

ImageModel parse_image(const JsonNode& node) {
  node.expect_keys({"delta", "filter_radius_px", "coverage", "edge_weight", "depth_tolerance", "segments"});
  ImageModel model;
  if (const auto value = node.find("delta")) model.delta = value->number();
  if (const auto value = node.find("filter_radius_px")) model.filter_radius_px = value->number();
  if (const auto value = node.find("coverage"))
    model.coverage = value->one_of({"soft", "hard"}) == 0 ? Coverage::soft : Coverage::hard;
  if (const auto value = node.find("edge_weight")) model.edge_weight = value->number();
  if (const auto value = node.find("depth_tolerance")) model.depth_tolerance = value->number();
  if (const auto value = node.find("segments")) model.segments = static_cast<int>(value->integer(1, 4096));
  return model;
}

void override_scene(const SceneOverrides& overrides, Scene& scene) {
  if (overrides.crop) {
    scene.film.crop_x = (*overrides.crop)[0];
    scene.film.crop_y = (*overrides.crop)[1];
    scene.film.crop_width = (*overrides.crop)[2];
    scene.film.crop_height = (*overrides.crop)[3];
  }
  if (overrides.shutter) scene.shutter = *overrides.shutter;
  ImageModel& model = scene.model;
  model.delta = overrides.delta.value_or(model.delta);
  model.filter_radius_px = overrides.filter_radius_px.value_or(model.filter_radius_px);
  model.edge_weight = overrides.edge_weight.value_or(model.edge_weight);
  model.depth_tolerance = overrides.depth_tolerance.value_or(model.depth_tolerance);
  model.coverage = overrides.coverage.value_or(model.coverage);
  if (overrides.segments) {
    model.segments = *overrides.segments;
    for (Object& object : scene.objects) object.segments = 0;
  }
}

/// What of the overrides and the film they lead to is in the image, one line.
std::string canonical(const Scene& scene, double points_scale) {
  const ImageModel& model = scene.model;
  const Film& film = scene.film;
  return nlohmann::json{film.width,
                        film.height,
                        film.crop_x,
                        film.crop_y,
                        film.crop_width,
                        film.crop_height,
                        scene.shutter.open,
                        scene.shutter.close,
                        model.delta,
                        model.filter_radius_px,
                        model.edge_weight,
                        model.depth_tolerance,
                        model.coverage == Coverage::soft,
                        model.segments,
                        points_scale}
      .dump();
}

void parse_version(const JsonNode& root) {
  if (!root.is_object()) root.fail("a scene file is one JSON object");
  const auto version = root.find("swept");
  if (!version) root.fail("no scene file: the key \"swept\", the format's version, is missing");
  const double number = version->number();
  if (number > static_cast<double>(format_version))
    version->fail("the file is of a newer version than this program reads, which is 1");
  if (number != static_cast<double>(format_version)) version->fail("the only version there is is 1");
}

void parse_scene(const JsonNode& root, const std::string& folder, const SceneOverrides& overrides,
                 Scene& scene, std::vector<ObjectSource>& sources) {
  parse_version(root);
  root.expect_keys({"swept", "film", "fps", "frame", "shutter", "camera", "background", "image", "objects"});
  if (const auto node = root.find("film")) scene.film = parse_film(*node);
  // Before the camera, whose field of view may be that of another axis.
  if (overrides.size) {
    scene.film.width = (*overrides.size)[0];
    scene.film.height = (*overrides.size)[1];
  }
  if (const auto node = root.find("fps")) scene.fps = parse_fps(*node);
  scene.frame = 1.0;
  if (const auto node = root.find("frame")) scene.frame = node->number();
  if (const auto node = root.find("shutter")) scene.shutter = parse_shutter(*node);
  if (const auto node = root.find("background")) scene.background = parse_background(*node);
  if (const auto node = root.find("image")) scene.model = parse_image(*node);
  scene.camera = parse_camera(root.require("camera"), scene.film);
  for (const JsonNode& node : root.require("objects").elements()) {
    io::ParsedObject parsed = io::parse_object(node, folder, scene.frame);
    scene.objects.push_back(std::move(parsed.object));
    sources.push_back(std::move(parsed.source));
  }
  override_scene(overrides, scene);
}

}  // namespace

std::string SceneFile::hash(const std::string& options) const {
  std::uint64_t state = 0xcbf29ce484222325u;
  for (const std::string* text : {&canonical_, &options})
    for (const char c : *text + '\n') state = (state ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  std::array<char, 17> digits;
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(state));
  return digits.data();
}

Result<SceneFile> read_scene_file(const std::string& path, const SceneOverrides& overrides) {
  const Result<std::string> text = read_text(path);
  if (!text) return text.error();
  return scene_from_text(*text, path, overrides);
}

Result<SceneFile> scene_from_text(const std::string& text, const std::string& path,
                                  const SceneOverrides& overrides) {
  const Result<nlohmann::json> document = io::parse_json(path, text);
  if (!document) return document.error();
  SceneFile file;
  file.path_ = path;
  try {
    parse_scene(JsonNode(*document, path), std::filesystem::path(path).parent_path().string(), overrides,
                file.scene_, file.sources_);
  } catch (const Error& error) {
    return error;
  } catch (const std::exception& exception) {
    return Error{path, "", exception.what()};
  }
  if (!(overrides.points_scale > 0.0) || !std::isfinite(overrides.points_scale))
    return Error{path, "points_scale", "must be a finite number above 0"};
  file.points_scale_ = overrides.points_scale;
  if (const Status valid = file.scene_.validate(); !valid) {
    Error error = valid.error();
    error.file = path;
    return error;
  }
  file.canonical_ = document->dump() + '\n' + canonical(file.scene_, file.points_scale_);
  return file;
}

}  // namespace swept
