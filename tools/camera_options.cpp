// Options for what a camera is otherwise than the scene says: orthographic, or with another lens.
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include "tools/scene_options.h"

namespace swept {
namespace {

constexpr const char* camera_group = "Camera, by default as the file says";

/// The number at the beginning of `text`, which it is taken from; none: NaN.
double take_number(std::string_view& text) {
  double value = std::nan("");
  const auto [rest, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || !std::isfinite(value)) return std::nan("");
  text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
  return value;
}

std::vector<CameraOverrides::Focus> focus_of(const std::string& given) {
  const auto fail = [&] {
    throw CLI::ValidationError("--focus", "expected DISTANCE or FRAME:DISTANCE,... above 0, found " + given);
  };
  std::vector<CameraOverrides::Focus> keys;
  std::string_view text = given;
  for (bool more = true; more;) {
    CameraOverrides::Focus key{0.0, take_number(text)};
    const bool framed = text.starts_with(':');
    if (framed) {
      text.remove_prefix(1);
      key = {key.distance, take_number(text)};
    }
    more = text.starts_with(',');
    if (more) text.remove_prefix(1);
    if (!(key.distance > 0.0) || std::isnan(key.frame) || (!framed && (more || !keys.empty()))) fail();
    if (!keys.empty() && !(keys.back().frame < key.frame)) fail();
    keys.push_back(key);
  }
  if (!text.empty()) fail();
  return keys;
}

}  // namespace

void add_camera_options(CLI::App& command, CameraOverrides& wanted) {
  const auto number = [&](const char* name, std::optional<double>& value, const char* help, double least) {
    command
        .add_option_function<std::string>(
            name,
            [name, &value, least](const std::string& given) {
              std::string_view text = given;
              const double parsed = take_number(text);
              if (!text.empty() || !(parsed >= least))
                throw CLI::ValidationError(name, "expected a number" +
                                                     std::string(least > 0.0    ? " above 0"
                                                                 : least == 0.0 ? " of 0 or more"
                                                                                : "") +
                                                     ", found " + given);
              value = parsed;
            },
            help)
        ->type_name("NUMBER")
        ->group(camera_group);
  };
  constexpr double positive = 1e-300, any_number = -1e300;
  command
      .add_option_function<std::string>(
          "--orthographic",
          [&wanted](const std::string& given) {
            std::string_view text = given;
            const double height = given == "auto" ? 0.0 : take_number(text);
            if (given != "auto" && (!text.empty() || !(height > 0.0)))
              throw CLI::ValidationError("--orthographic",
                                         "expected a height above 0 or auto, found " + given);
            wanted.height = height;
          },
          "Look along parallel rays at so many world units along the film's height; auto: at as many as the "
          "camera sees at its target")
      ->type_name("HEIGHT|auto")
      ->group(camera_group);
  command.add_flag("--no-lens", wanted.no_lens, "Everything is in focus, whatever lens the scene has")
      ->group(camera_group);
  number("--aperture", wanted.aperture, "Diameter of the lens, world units; 0: everything is in focus", 0.0);
  number("--f-number", wanted.f_number, "The aperture as --focal-length over this", positive);
  number("--focal-length", wanted.focal_length, "World units; goes with --f-number", positive);
  command
      .add_option_function<std::string>(
          "--focus", [&wanted](const std::string& given) { wanted.focus = focus_of(given); },
          "Depth that is in focus, world units, or one at each of several frames [what look-ats look at]")
      ->type_name("DISTANCE|FRAME:DISTANCE,...")
      ->group(camera_group);
  command.add_option("--blades", wanted.blades, "Corners of the lens's opening [round]")
      ->check(CLI::Range(3, 64))
      ->group(camera_group);
  number("--lens-rotation", wanted.rotation_degrees, "Of its first corner, clockwise from the right, degrees",
         any_number);
  command
      .add_option("--lens-points", wanted.lens_points,
                  "Points that the lens is looked through [as many as the error asked for takes]")
      ->check(CLI::Range(1, 4096))
      ->group(camera_group);
}

}  // namespace swept
