#include "tools/scene_options.h"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/core.h>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

namespace swept {
namespace {

/// Exactly N numbers with a separator between them and nothing else.
template <class Number, std::size_t N>
std::optional<std::array<Number, N>> parse_list(std::string_view text, char separator) {
  std::array<Number, N> numbers{};
  const char *at = text.data(), *end = text.data() + text.size();
  for (std::size_t i = 0; i < N; ++i) {
    if (i > 0 && (at == end || *at++ != separator)) return std::nullopt;
    const auto [rest, code] = std::from_chars(at, end, numbers[i]);
    if (code != std::errc()) return std::nullopt;
    at = rest;
  }
  return at == end ? std::optional(numbers) : std::nullopt;
}

constexpr int max_side_px = 65536;

void set_size(SceneOverrides& overrides, const std::string& text) {
  overrides.size = parse_list<int, 2>(text, 'x');
  if (!overrides.size) throw CLI::ValidationError("--size", "expected WIDTHxHEIGHT in pixels, found " + text);
  for (const int side : *overrides.size)
    if (side < 1 || side > max_side_px)
      throw CLI::ValidationError("--size", fmt::format("sides must be between 1 and {}", max_side_px));
}

void set_crop(SceneOverrides& overrides, const std::string& text) {
  overrides.crop = parse_list<int, 4>(text, ',');
  if (!overrides.crop) throw CLI::ValidationError("--crop", "expected X,Y,WIDTH,HEIGHT, found " + text);
  const auto& [x, y, width, height] = *overrides.crop;
  if (x < 0 || y < 0 || width < 1 || height < 1)
    throw CLI::ValidationError("--crop", "the crop must be a window of at least one pixel inside the film");
}

void set_shutter(SceneOverrides& overrides, const std::string& text) {
  const auto times = parse_list<double, 2>(text, ',');
  if (!times || !std::isfinite((*times)[0]) || !std::isfinite((*times)[1]))
    throw CLI::ValidationError("--shutter", "expected OPEN,CLOSE in frames, found " + text);
  overrides.shutter = Shutter{(*times)[0], (*times)[1]};
  if (overrides.shutter->close < overrides.shutter->open)
    throw CLI::ValidationError("--shutter", "the shutter closes before it opens");
}

/// An option of the image model, held to the range that ImageModel::validate() states.
template <class Member>
void add_model_option(CLI::App& command, const std::string& name, double ImageModel::*model_member,
                      const std::shared_ptr<SceneOverrides>& overrides, Member override_member,
                      const std::string& help) {
  command
      .add_option_function<double>(
          name,
          [=](const double& value) {
            ImageModel model;
            model.*model_member = value;
            if (const Status valid = model.validate(); !valid)
              throw CLI::ValidationError(name, valid.error().reason);
            (*overrides).*override_member = value;
          },
          help)
      ->group("Image");
}

}  // namespace

std::shared_ptr<const SceneOverrides> add_scene_options(CLI::App& command) {
  auto overrides = std::make_shared<SceneOverrides>();
  const auto add = [&](const char* name, auto set, const char* type, const char* help) {
    command
        .add_option_function<std::string>(
            name, [=](const std::string& text) { set(*overrides, text); }, help)
        ->type_name(type)
        ->group("Scene");
  };
  add("--size", set_size, "WxH", "Film size in pixels");
  add("--crop", set_crop, "X,Y,W,H", "Window of the film to compute, pixels from the top left");
  add("--shutter", set_shutter, "OPEN,CLOSE", "Shutter times in frames relative to the frame");
  command
      .add_option("--segments", overrides->segments,
                  "Linear motion segments over the shutter, for all objects")
      ->check(CLI::Range(1, 4096))
      ->group("Scene");
  command.add_option("--points-scale", overrides->points_scale, "Multiply the points of generated objects")
      ->check([](const std::string& text) {
        const auto scale = parse_list<double, 1>(text, ',');
        return scale && (*scale)[0] > 0.0 && std::isfinite((*scale)[0]) ? "" : "must be above 0: " + text;
      })
      ->group("Scene");
  add_model_option(command, "--delta", &ImageModel::delta, overrides, &SceneOverrides::delta,
                   "Kernel sharpness, the d of exp(-d r^2)");
  add_model_option(command, "--filter-radius", &ImageModel::filter_radius_px, overrides,
                   &SceneOverrides::filter_radius_px, "Pixel filter's radius at the cut-off, pixels");
  add_model_option(command, "--edge-weight", &ImageModel::edge_weight, overrides,
                   &SceneOverrides::edge_weight, "Kernel sum at which soft coverage is full");
  add_model_option(command, "--depth-tolerance", &ImageModel::depth_tolerance, overrides,
                   &SceneOverrides::depth_tolerance, "Thickness of a surface, in radii");
  command
      .add_option_function<std::string>(
          "--coverage",
          [=](const std::string& word) {
            overrides->coverage = word == "soft" ? Coverage::soft : Coverage::hard;
          },
          "How silhouettes are covered")
      ->check(CLI::IsMember({"soft", "hard"}))
      ->group("Image");
  return overrides;
}

int report_scene_error(const char* command, const Error& error) {
  fmt::print(stderr, "swept {}: {}\n", command, error.message());
  // Files have no crop: it can only be the option.
  return error.field == "/film/crop" ? 2 : 1;
}

}  // namespace swept
