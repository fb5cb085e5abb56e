#include "tools/stitch_command.h"

#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "splat/io/stitch_exr.h"
#include "tools/console.h"
#include "tools/outputs.h"

namespace swept {
namespace {

struct StitchArguments {
  std::vector<std::string> parts;
  std::string output;
  bool overwrite = false;
};

Status stitch(const StitchArguments& arguments) {
  for (const std::string& part : arguments.parts) {
    std::error_code code;
    if (std::filesystem::equivalent(arguments.output, part, code))
      return Error{arguments.output, "--output", "is one of the parts"};
  }
  const Existing existing = arguments.overwrite ? Existing::overwrite : Existing::refuse;
  if (Status writable = check_output_file(arguments.output, existing); !writable) return writable;
  return stitch_exr(arguments.parts, arguments.output,
                    arguments.overwrite ? IfExists::replace : IfExists::fail);
}

}  // namespace

void add_stitch_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<StitchArguments>();
  CLI::App* command = app.add_subcommand(
      "stitch", "Put the crops of a frame together, as the frame is when it is rendered whole");
  command->footer(std::string("Example:\n"
                              "  swept render scene.json -o left.exr --crop 0,0,512,576\n"
                              "  swept render scene.json -o right.exr --crop 512,0,512,576\n"
                              "  swept stitch left.exr right.exr -o whole.exr\n\n") +
                  exit_codes_help);
  command->add_option("parts", arguments->parts, "What swept render --crop wrote, in any order")
      ->required()
      ->type_name("PART.exr");
  command->add_option("-o,--output", arguments->output, "Where to write")
      ->required()
      ->type_name("FILE.exr")
      ->check([](const std::string& path) {
        return std::filesystem::path(path).extension() == ".exr" ? "" : "must end in .exr: " + path;
      });
  command->add_flag("--overwrite", arguments->overwrite, "Replace a file that exists");
  command->callback([arguments, &exit_code] {
    const Status status = stitch(*arguments);
    exit_code = status.ok() ? 0 : 1;
    if (!status) log("swept stitch: {}\n", status.error().message());
  });
}

}  // namespace swept
