#include "tools/scene_options.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include "splat/fields.h"
#include "tools/console.h"

namespace swept {
namespace {

constexpr const char* scene_group = "Scene, by default as the file says";
constexpr const char* image_group = "Image model, by default as the file says";

/// The numbers that `text` is; none if it is anything else.
std::vector<double> numbers_in(std::string_view text, char separator) {
  std::vector<double> numbers;
  for (bool more = true; more;) {
    double value = 0.0;
    const auto [rest, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc()) return {};
    text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
    numbers.push_back(value);
    more = !text.empty() && text.front() == separator;
    if (more) text.remove_prefix(1);
  }
  return text.empty() ? numbers : std::vector<double>();
}

/// An option, and the fields that it sets from left to right.
struct FieldOption {
  std::string name;
  char separator;
  std::vector<const Field*> fields;

  /// "WIDTHxHEIGHT", "R,G,B[,A]", "soft|hard".
  [[nodiscard]] std::string type_name() const {
    std::string text;
    if (fields.front()->count != nullptr) {
      const std::string number(fields.front()->numbers.front().name);
      return number + separator + number + "[" + separator + "...]";
    }
    for (const Field* field : fields) {
      for (const std::string_view word : field->words) (text += text.empty() ? "" : "|") += word;
      for (std::size_t i = 0; i < field->numbers.size() && field->words.empty(); ++i) {
        const bool first = text.empty(), may_lack = i >= field->least;
        text += may_lack ? "[" : "";
        if (!first) text += separator;
        text += field->numbers[i].name;
        text += may_lack ? "]" : "";
      }
    }
    return text;
  }

  [[nodiscard]] std::string help() const {
    std::string text;
    for (const Field* field : fields) {
      (text += text.empty() ? "" : "; ") += field->help;
      if (field->words.empty() && field->numbers.size() == 1) text += " (" + range_text(*field) + ")";
    }
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    return text;
  }

  [[noreturn]] void fail(const std::string& reason) const { throw CLI::ValidationError(name, reason); }

  void set(const std::string& text, FieldValues& values) const {
    if (const Field& field = *fields.front(); !field.words.empty()) {
      const auto word = std::find(field.words.begin(), field.words.end(), text);
      if (word == field.words.end()) fail("expected " + type_name() + ", found " + text);
      values[std::string(field.pointer)] = {static_cast<double>(word - field.words.begin())};
      return;
    }
    const std::vector<double> numbers = numbers_in(text, separator);
    std::size_t least = 0, most = 0;
    for (const Field* field : fields) {
      least += std::min(field->least, field->numbers.size());
      most += field->numbers.size();
    }
    if (numbers.size() < least || numbers.size() > most) fail("expected " + type_name() + ", found " + text);
    std::size_t begin = 0;
    for (const Field* field : fields) {
      const std::size_t end = std::min(numbers.size(), begin + field->numbers.size());
      std::vector<double> own(numbers.begin() + static_cast<std::ptrdiff_t>(begin),
                              numbers.begin() + static_cast<std::ptrdiff_t>(end));
      begin = end;
      if (const Status legal = field->legal(own); !legal) fail(legal.error().reason + ": " + text);
      values[std::string(field->pointer)] = std::move(own);
    }
  }
};

std::vector<FieldOption> field_options() {
  std::vector<FieldOption> options;
  for (const Field& field : scene_fields()) {
    if (options.empty() || options.back().name != field.option)
      options.push_back({std::string(field.option), field.separator, {}});
    options.back().fields.push_back(&field);
  }
  return options;
}

/// Whether the number is one and nothing follows.
std::string check_points_scale(const std::string& text) {
  double scale = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), scale);
  const bool number = code == std::errc() && end == text.data() + text.size();
  return number && scale > 0.0 && std::isfinite(scale) ? "" : "must be above 0: " + text;
}

}  // namespace

void add_up_option(CLI::App& command, std::optional<Eigen::Vector3d>& up, const char* help) {
  const auto parse = [&up](const std::string& text) {
    std::string_view name = text;
    const bool minus = name.starts_with('-');
    if (minus) name.remove_prefix(1);
    if (const std::size_t axis = std::string_view("xyz").find(name); name.size() == 1 && axis < 3) {
      up = (minus ? -1.0 : 1.0) * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(axis));
      return;
    }
    const std::vector<double> numbers = numbers_in(text, ',');
    if (numbers.size() != 3)
      throw CLI::ValidationError("--up", "expected x, y, z, -x, -y, -z or X,Y,Z, found " + text);
    const Eigen::Vector3d vector(numbers[0], numbers[1], numbers[2]);
    if (!vector.allFinite() || vector.isZero(0.0))
      throw CLI::ValidationError("--up", "must be finite and not zero: " + text);
    up = vector;
  };
  command.add_option_function<std::string>("--up", parse, help)->type_name("AXIS|X,Y,Z");
}

std::shared_ptr<const SceneOverrides> add_scene_options(CLI::App& command) {
  auto overrides = std::make_shared<SceneOverrides>();
  for (const FieldOption& option : field_options()) {
    const std::string_view group = option.fields.front()->group();
    const bool of_image = group == "image" || group == "splats";
    command
        .add_option_function<std::string>(
            option.name,
            [option, overrides](const std::string& text) { option.set(text, overrides->fields); },
            option.help())
        ->type_name(option.type_name())
        ->group(of_image ? image_group : scene_group);
  }
  command
      .add_option(
          "--camera", overrides->camera_file,
          "Take the camera from transforms.json or a camera path of nerfstudio or instant-ngp, or from "
          "COLMAP's folder of cameras.txt and images.txt, or from glTF; its frames are those from 1 on")
      ->type_name("FILE")
      ->group(scene_group);
  add_camera_options(command, overrides->camera);
  add_up_option(command, overrides->up,
                "Which way is up, for points without a scene file and look-at cameras");
  command.get_option("--up")->group(scene_group);
  command
      .add_option_function<std::string>(
          "--draw",
          [overrides](const std::string& text) {
            overrides->draw = text == "splats"    ? DrawAs::splats
                              : text == "surfels" ? DrawAs::surfels
                                                  : DrawAs::triangles;
          },
          "What files are drawn as [splats where they are trained ones, else surfels]; triangles are those "
          "of meshes")
      ->check(CLI::IsMember({"splats", "surfels", "triangles"}))
      ->type_name("splats|surfels|triangles")
      ->group(scene_group);
  command
      .add_option(
          "--texture", overrides->texture,
          "Lay this PNG or EXR over what is drawn as triangles, by the texture coordinates of OBJ and PLY")
      ->type_name("FILE")
      ->group(scene_group);
  command
      .add_option("--crease-angle", overrides->crease_angle,
                  "Where triangles meet at a greater angle they do not share a normal; by default all about "
                  "a point do")
      ->check(CLI::Range(0.0, 180.0))
      ->type_name("DEGREES")
      ->group(scene_group);
  command.add_option("--points-scale", overrides->points_scale, "Multiply the points of generated objects")
      ->check(check_points_scale)
      ->group(scene_group);
  return overrides;
}

int report_scene_error(const char* command, const Error& error, const SceneOverrides& overrides) {
  log("swept {}: {}\n", command, error.message());
  const auto about = [&](const auto& given) { return given.first.starts_with(error.field); };
  const bool said =
      !error.field.empty() && std::any_of(overrides.fields.begin(), overrides.fields.end(), about);
  const bool about_camera = error.kind == ErrorKind::argument && error.field.starts_with("/camera/");
  return said || about_camera ? 2 : 1;
}

}  // namespace swept
