#include "tools/init_command.h"

#include <filesystem>
#include <memory>
#include <string>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "splat/io/atomic_file.h"
#include "splat/io/cloud_scene.h"
#include "splat/io/point_file.h"
#include "splat/io/splat_file.h"
#include "tools/console.h"
#include "tools/outputs.h"
#include "tools/scene_options.h"

namespace swept {
namespace {

struct InitArguments {
  std::string points, output = "scene.json";
  bool overwrite = false;
  SceneOverrides overrides;  ///< up alone
};

int fail(const Error& error) {
  log("swept init: {}\n", error.message());
  return 1;
}

int init(const InitArguments& arguments) {
  const std::filesystem::path output(arguments.output);
  if (output.extension() != ".json")
    throw CLI::ValidationError("--output", "must end in .json: " + arguments.output);
  if (!is_point_file_name(arguments.points) && !is_splat_file_name(arguments.points))
    throw CLI::ValidationError("points", "is no point file by its name: " + arguments.points);
  std::error_code code;
  if (std::filesystem::equivalent(output, arguments.points, code))
    return fail({arguments.output, "--output", "is what the points are read from"});
  const Existing existing = arguments.overwrite ? Existing::overwrite : Existing::refuse;
  if (const Status status = check_output_file(arguments.output, existing); !status)
    return fail(status.error());
  const Result<CloudScene> scene =
      scene_of_points(arguments.points, output.parent_path().string(), arguments.overrides);
  if (!scene) return fail(scene.error());
  // What is written must be readable.
  if (const auto read = scene_from_text(scene->text, arguments.output); !read) return fail(read.error());
  if (const Status written = write_file(arguments.output, scene->text); !written)
    return fail(written.error());
  for (const std::string& line : scene->assumed) log("note: {}\n", printable(line));
  log("{}: written\n", printable(arguments.output));
  return 0;
}

}  // namespace

void add_init_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<InitArguments>();
  CLI::App* command =
      app.add_subcommand("init", "Write the scene file by which points are drawn, to go on from");
  command->footer(std::string("Examples:\n"
                              "  swept init cloud.ply -o scene.json\n"
                              "  swept init 'anim.%04d.ply' -o scene.json --up z\n"
                              "\n") +
                  exit_codes_help);
  command->add_option("points", arguments->points, "A point file, or numbered ones as anim.%04d.ply")
      ->required()
      ->type_name("POINTS");
  command->add_option("-o,--output", arguments->output, "The scene file")
      ->type_name("FILE.json")
      ->capture_default_str();
  add_up_option(*command, arguments->overrides.up, "Which way is up; else what the file lets guess");
  command->add_flag("--overwrite", arguments->overwrite, "Replace a scene file that exists");
  command->callback([arguments, &exit_code] { exit_code = init(*arguments); });
}

}  // namespace swept
