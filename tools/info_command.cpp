#include "tools/info_command.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "datasets/generators.h"
#include "splat/fields.h"
#include "splat/io/cloud_scene.h"
#include "splat/io/scene_file.h"
#include "tools/console.h"
#include "tools/gpu_method.h"
#include "tools/scene_options.h"
#include "tools/scene_report.h"
#include "tools/unused_members.h"
#include "tools/unused_options.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

struct InfoArguments {
  std::string scene;
  std::optional<double> frame;
  bool json = false, gpus = false;
  std::shared_ptr<const SceneOverrides> overrides;
};

std::string text_of(const Eigen::Vector3d& v) {
  // Enough digits for a centimetre at survey coordinates, without the noise of a double's last ones.
  return fmt::format("{:.9g} {:.9g} {:.9g}", v.x(), v.y(), v.z());
}

const char* yes(bool value) { return value ? "yes" : "no"; }

void print_text(const SceneFile& file, const Scene& scene, const SceneReport& report) {
  const Film& film = scene.film;
  const CameraReport& camera = report.camera;
  fmt::print("scene     {}, hash {}\n", printable(file.path()), report.hash);
  fmt::print("frame     {} at {}/{} frames per second\n", report.frame, scene.fps.numerator,
             scene.fps.denominator);
  fmt::print("shutter   {} to {} frames, {:.6g} s, {:.6g} degrees\n", scene.shutter.open, scene.shutter.close,
             report.exposure_seconds, report.shutter_angle_degrees);
  if (const Field* curve = find_field("/shutter/curve"); scene.shutter.curve != ShutterShape::box)
    fmt::print("          light comes in as a {}\n", value_text(*curve, curve->get(scene)));
  fmt::print("film      {} x {} px, window {} x {} at {}, {}\n", film.width, film.height, film.window_width(),
             film.window_height(), film.window_x(), film.window_y());
  fmt::print("camera    mid-shutter, world space, {}\n",
             camera.moves ? "moves while the shutter is open" : "stands still");
  fmt::print("  eye     {}\n  right   {}\n  down    {}\n  forward {}\n", text_of(camera.eye),
             text_of(camera.right), text_of(camera.down), text_of(camera.forward));
  if (camera.height > 0.0)
    fmt::print("  view    orthographic, {:.6g} world units high; near {:.6g} world units\n", camera.height,
               camera.near);
  else
    fmt::print("  fov     {:.6g} degrees horizontal, {:.6g} vertical; near {:.6g} world units\n",
               camera.fov_x_degrees, camera.fov_y_degrees, camera.near);
  fmt::print("  lens    {} {:.6g} and {:.6g} px, principal point at {:.6g}, {:.6g}\n",
             camera.height > 0.0 ? "a world unit is" : "focal lengths", camera.focal_px.x(),
             camera.focal_px.y(), camera.center_px.x(), camera.center_px.y());
  fmt::print("objects   {}, lengths in world units\n", report.objects.size());
  for (const ObjectReport& object : report.objects) {
    fmt::print("  {}\n", printable(object.name));
    fmt::print("    source    {}\n", printable(object.source));
    fmt::print("    points    {}, {} keys\n", object.points, object.keys);
    fmt::print("    moves     points {}, object {}; {} segments\n", yes(object.points_move),
               yes(object.object_moves), object.segments);
    if (!object.velocity_unit.empty())
      fmt::print("    velocity  {}\n", object.velocity_unit == "per_frame" ? "per frame" : "per second");
    fmt::print("    streak    {:.6g} px at the longest\n", object.longest_streak_px);
    if (object.splats)
      fmt::print("    surface   none: Gaussian splats\n");
    else
      fmt::print("    surface   {}, {}\n", object.two_sided ? "two-sided" : "one-sided",
                 object.has_opacity ? "transparent in places" : "opaque");
    fmt::print("    plan      {}\n", object.plan.text());
    if (object.points > 0)
      fmt::print("    bounds    {}  to  {}\n", text_of(object.low), text_of(object.high));
  }
  fmt::print("effects\n");
  for (const std::string& effect : report.effects) fmt::print("  {}\n", effect);
  if (!report.notes.empty()) fmt::print("notes\n");
  for (const std::string& note : report.notes) fmt::print("  {}\n", printable(note));
}

Json json_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json json_of(const ObjectReport& object) {
  Json json = {{"name", object.name},
               {"source", object.source},
               {"points", object.points},
               {"keys", object.keys},
               {"points_move", object.points_move},
               {"object_moves", object.object_moves},
               {"segments", object.segments},
               {"velocity_unit", nullptr},
               {"longest_streak_px", object.longest_streak_px},
               {"two_sided", object.two_sided},
               {"has_opacity", object.has_opacity},
               {"splats", object.splats},
               {"plan", object.plan.json()},
               {"bounds", nullptr}};
  if (!object.velocity_unit.empty()) json["velocity_unit"] = object.velocity_unit;
  if (object.points > 0) json["bounds"] = {{"low", json_of(object.low)}, {"high", json_of(object.high)}};
  return json;
}

void print_json(const SceneFile& file, const Scene& scene, const SceneReport& report) {
  const Film& film = scene.film;
  const CameraReport& camera = report.camera;
  Json json = {{"scene", file.path()},
               {"hash", report.hash},
               {"frame", report.frame},
               {"fps", {scene.fps.numerator, scene.fps.denominator}},
               {"shutter", {{"open", scene.shutter.open}, {"close", scene.shutter.close}}},
               {"exposure_seconds", report.exposure_seconds},
               {"shutter_angle_degrees", report.shutter_angle_degrees},
               {"film", {{"width", film.width}, {"height", film.height}}},
               {"window", {film.window_x(), film.window_y(), film.window_width(), film.window_height()}},
               {"camera",
                {{"eye", json_of(camera.eye)},
                 {"right", json_of(camera.right)},
                 {"down", json_of(camera.down)},
                 {"forward", json_of(camera.forward)},
                 {"fov_x_degrees", camera.fov_x_degrees},
                 {"fov_y_degrees", camera.fov_y_degrees},
                 {"height", camera.height},
                 {"focal_px", {camera.focal_px.x(), camera.focal_px.y()}},
                 {"center_px", {camera.center_px.x(), camera.center_px.y()}},
                 {"near", camera.near},
                 {"moves", camera.moves}}},
               {"effects", report.effects},
               {"notes", report.notes}};
  json["objects"] = Json::array();
  for (const ObjectReport& object : report.objects) json["objects"].push_back(json_of(object));
  // A path need not be UTF-8.
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

int list_devices(const InfoArguments& arguments) {
  const Result<std::vector<std::string>> devices = describe_gpus();
  if (!devices) {
    log("swept info: {}\n", devices.error().message());
    return 1;
  }
  if (arguments.json)
    fmt::print("{}\n", Json{{"gpus", *devices}}.dump(2, ' ', false, Json::error_handler_t::replace));
  else if (devices->empty())
    fmt::print("EGL lists no devices\n");
  else
    for (const std::string& device : *devices) fmt::print("{}\n", device);
  return 0;
}

int info(const InfoArguments& arguments) {
  if (arguments.gpus) return list_devices(arguments);
  if (arguments.scene.empty()) throw CLI::RequiredError("scene, or --gpus,");
  Result<SceneFile> file = read_scene_or_points(arguments.scene, *arguments.overrides);
  if (!file) return report_scene_error("info", file.error(), *arguments.overrides);
  const double frame = arguments.frame.value_or(file->scene().frame);
  const Result<const Scene*> scene = file->scene_at(frame, generate);
  if (!scene) return report_scene_error("info", scene.error(), *arguments.overrides);
  const Result<std::string> hash = file->hash(frame);
  if (!hash) return report_scene_error("info", hash.error(), *arguments.overrides);
  SceneReport report = report_scene(*file, **scene);
  report.hash = *hash;
  for (const UnusedOption& unused : unused_options(*arguments.overrides, nullptr, *file, **scene))
    report.notes.push_back(unused.text());
  for (const UnusedMember& unused : unused_members(*arguments.overrides, *file, **scene))
    report.notes.push_back(unused.text(file->path()));
  if (arguments.json)
    print_json(*file, **scene, report);
  else
    print_text(*file, **scene, report);
  return 0;
}

}  // namespace

void add_info_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<InfoArguments>();
  CLI::App* command = app.add_subcommand("info", "Say what a scene file holds and what it resolves to");
  command->footer(
      std::string("Examples:\n"
                  "  swept info cloud.ply                  what would be drawn of it, and what was assumed\n"
                  "  swept info scene.json --frame 12 --json\n"
                  "  swept info --gpus                     devices of the GPU modes\n"
                  "\n") +
      exit_codes_help);
  auto* scene =
      command->add_option("scene", arguments->scene, "The scene file, or the points alone, as for render")
          ->type_name("SCENE");
  command->add_flag("--gpus", arguments->gpus, "List the devices of the GPU modes instead")->excludes(scene);
  command->add_option("--frame", arguments->frame, "The frame to look at; by default the scene's own")
      ->check(CLI::Range(-1e9, 1e9));
  command->add_flag("--json", arguments->json, "Print JSON");
  arguments->overrides = add_scene_options(*command);
  command->callback([arguments, &exit_code] { exit_code = info(*arguments); });
}

}  // namespace swept
