// The swept command. Exit codes: 0 done, 1 something failed, 2 bad arguments.
#include <algorithm>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "splat/io/point_file.h"
#include "splat/io/suggestion.h"
#include "tools/compare_command.h"
#include "tools/completion.h"
#include "tools/console.h"
#include "tools/info_command.h"
#include "tools/init_command.h"
#include "tools/render_command.h"
#include "tools/scene_schema.h"
#include "tools/stitch_command.h"
#include "tools/study/study_command.h"
#include "tools/study/worker.h"

namespace {

constexpr const char* footer = R"(Examples:
  swept render cloud.ply -o picture.exr                    points, without a scene file
  swept init cloud.ply -o scene.json                       the scene file to go on from
  swept info scene.json                                    what a scene holds
  swept render scene.json -o picture.exr                   its own frame
  swept render scene.json -o f.%04d.exr --frames 1-100x2   every other one of a hundred
  swept compare right.exr other.exr --min-psnr 60          how far apart two pictures are

Exit codes: 0 done, 1 something failed, 2 bad arguments.)";

/// What may have been meant by the first word that is not known; empty: none is near one that is.
std::string_view meant(const CLI::App& app, int argc, char** argv) {
  const CLI::App* command = nullptr;
  std::vector<std::string> names;
  const auto nearest = [&](std::string_view word) {
    // Static, for the view that is returned.
    static std::vector<std::string> kept;
    kept = std::move(names);
    const std::vector<std::string_view> known(kept.begin(), kept.end());
    return swept::nearest_word(word, known);
  };
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i], name = word.substr(0, word.find('='));
    if (command == nullptr && !word.starts_with("-")) {
      for (const CLI::App* known : app.get_subcommands(nullptr)) {
        if (known->get_name() == word) command = known;
        if (!known->get_group().empty()) names.push_back(known->get_name());
      }
      if (command == nullptr) return nearest(word);
      names.clear();
      continue;
    }
    const CLI::App& here = command == nullptr ? app : *command;
    if (!word.starts_with("--") || here.get_option_no_throw(name) != nullptr) continue;
    for (const CLI::Option* known : here.get_options())
      for (const std::string& option : known->get_lnames()) names.push_back("--" + option);
    return nearest(name);
  }
  return {};
}

/// Whether a shell made several files of a pattern that was not in quotes.
bool names_several_clouds(int argc, char** argv) {
  std::error_code code;
  return std::count_if(argv + 1, argv + argc, [&](const char* word) {
           return swept::is_point_file_name(word) && std::filesystem::exists(word, code);
         }) > 1;
}

int run(int argc, char** argv) {
  CLI::App app("Exact motion blur for point clouds", "swept");
  app.set_version_flag("--version", "swept " SWEPT_VERSION);
  app.require_subcommand(1);
  app.footer(footer);
  int exit_code = 0;
  try {
    swept::add_render_command(app, exit_code);
    swept::add_info_command(app, exit_code);
    swept::add_init_command(app, exit_code);
    swept::add_compare_command(app, exit_code);
    swept::add_stitch_command(app, exit_code);
    swept::add_study_command(app, exit_code);
    swept::add_study_worker_command(app, exit_code);
    swept::add_completion_command(app);
    CLI::App* schema = app.add_subcommand("schema", "Print a JSON schema of scene files, for editors");
    schema->footer(std::string("Example:\n  swept schema > scene.schema.json\n\n") + swept::exit_codes_help);
    schema->callback([] { fmt::print("{}", swept::scene_schema()); });
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Help and version are "errors" with code 0.
    if (app.exit(error) == 0) return 0;
    if (const std::string_view word = meant(app, argc, argv); !word.empty())
      swept::log("Did you mean {}?\n", word);
    else if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && names_several_clouds(argc, argv))
      swept::log("Numbered files are one argument, in quotes: 'name.%04d.ply'\n");
    return 2;
  } catch (const std::bad_alloc&) {
    swept::log("swept: not enough memory\n");
    return 1;
  } catch (const std::exception& error) {
    swept::log("swept: {}\n", error.what());
    return 1;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  swept::prepare_console();
  const int exit_code = run(argc, argv);
  if (swept::finish_console()) return exit_code;
  return exit_code != 0 ? exit_code : 1;
}
