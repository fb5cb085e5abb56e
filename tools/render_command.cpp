#include "tools/render_command.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <sys/resource.h>

#include <ImfThreading.h>
#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "datasets/generators.h"
#include "splat/io/atomic_file.h"
#include "splat/io/cloud_scene.h"
#include "splat/io/scene_file.h"
#include "splat/io/scene_inputs.h"
#include "splat/io/sequence.h"
#include "tools/console.h"
#include "tools/frame_memory.h"
#include "tools/memory_limit.h"
#include "tools/outputs.h"
#include "tools/render_frames.h"
#include "tools/render_methods.h"
#include "tools/scene_options.h"
#include "tools/stats_json.h"
#include "tools/unused_members.h"
#include "tools/unused_options.h"

namespace swept {
namespace {

struct RenderArguments {
  std::string scene, output, preview, deep, stats;
  std::vector<int> frames;  ///< empty: the scene's own
  int part = 0, parts = 0;  ///< which of so many strips of the film; 0: all of it
  bool half = false, no_load_ahead = false, overwrite = false, skip_existing = false, dry_run = false;
  std::uint64_t max_memory = 0;  ///< bytes; 0: no bound
  RenderControl control;
  std::shared_ptr<const SceneOverrides> overrides;
  std::shared_ptr<const MethodChoice> method;
  std::shared_ptr<const LayerOptions> layers;
};

int fail(const Error& error, int exit_code = 1) {
  log("swept render: {}\n", error.message());
  return exit_code;
}

/// How many of them are rendered.
std::size_t rendered(const std::vector<FrameOutput>& outputs) {
  return static_cast<std::size_t>(
      std::count_if(outputs.begin(), outputs.end(), [](const FrameOutput& output) { return !output.skip; }));
}

/// Of options that change nothing of a frame, and of members that change nothing of any.
std::vector<std::string> remarks_on(const RenderArguments& arguments, const SceneFile& file,
                                    const Scene& scene, RunMembers& members) {
  std::vector<std::string> remarks =
      members.of_frame(unused_members(*arguments.overrides, file, scene), file.path());
  for (const UnusedOption& unused : unused_options(*arguments.overrides, arguments.method.get(), file, scene))
    remarks.push_back(unused.text());
  if (std::string unseen = unseen_error(*arguments.method, scene); !unseen.empty())
    remarks.push_back(std::move(unseen));
  return remarks;
}

/// Loads what the frames need and prints what would be done with them.
int dry_run(SceneFile& file, const std::vector<FrameOutput>& outputs, const RenderArguments& arguments) {
  std::set<std::string> told;
  RunMembers members(rendered(outputs));
  for (const FrameOutput& output : outputs) {
    const std::string name = output.image.empty() ? "" : " " + printable(output.image);
    if (output.skip) {
      fmt::print("frame {}: skip{}\n", output.frame, name);
      continue;
    }
    const Result<const Scene*> scene = file.scene_at(output.frame, generate);
    if (!scene) return fail(scene.error());
    for (const std::string& remark : remarks_on(arguments, file, **scene, members))
      if (told.insert(remark).second) log("note: {}\n", remark);
    std::size_t points = 0;
    for (const Object& object : (*scene)->objects) points += object.cloud.size() + object.splats.size();
    fmt::print("frame {}: render{} {} points\n", output.frame, name, points);
  }
  return 0;
}

/// Options that contradict each other; thrown as a parse error.
void check_arguments(const RenderArguments& arguments) {
  if (arguments.output.empty() && !arguments.dry_run)
    throw CLI::ValidationError("--output", "is required without --dry-run");
  const auto check_extension = [](const char* option, const std::string& path, const char* extension) {
    if (!path.empty() && std::filesystem::path(path).extension() != extension)
      throw CLI::ValidationError(option, fmt::format("must end in {}: {}", extension, path));
  };
  if (arguments.method->method != "sampled" && (arguments.layers->samples || arguments.layers->error))
    throw CLI::ValidationError("--layers", "samples and error go with --method sampled");
  if (arguments.method->method != "abuffer" && !arguments.deep.empty())
    throw CLI::ValidationError("--deep", "goes with --exact (--method abuffer)");
  check_extension("--output", arguments.output, ".exr");
  check_extension("--deep", arguments.deep, ".exr");
  check_extension("--preview", arguments.preview, ".png");
  check_extension("--stats-json", arguments.stats, ".json");
}

/// No output may replace what is read for the picture, such as a texture.
Status check_inputs_stay(const SceneFile& file, const std::vector<FrameOutput>& outputs,
                         const RenderArguments& arguments) {
  std::vector<std::pair<const char*, std::string>> replaced;
  const auto add = [&](const char* option, const std::string& path) {
    std::error_code code;
    if (!path.empty() && std::filesystem::exists(path, code)) replaced.emplace_back(option, path);
  };
  for (const FrameOutput& output : outputs) {
    if (output.skip) continue;
    add("--output", output.image);
    add("--preview", output.preview);
    add("--deep", output.deep);
  }
  add("--stats-json", arguments.stats);
  if (replaced.empty()) return Done{};
  Result<std::vector<std::string>> inputs = io::files_read(file, outputs.front().frame);
  if (!inputs) return inputs.error();
  inputs->push_back(arguments.scene);
  inputs->push_back(arguments.overrides->camera_file);
  for (const auto& [option, path] : replaced)
    for (const std::string& input : *inputs) {
      std::error_code code;
      if (std::filesystem::equivalent(path, input, code))
        return Error{path, option,
                     input == arguments.scene ? "is the scene file" : "is read for the picture"};
    }
  return Done{};
}

/// What besides the scene tells this picture from others.
std::string picture_of(const RenderArguments& arguments, const PreparedMethod& method) {
  return method.picture + (arguments.half ? ", half floats" : "") + arguments.layers->text();
}

int render_all(SceneFile& file, const std::vector<FrameOutput>& outputs, const PreparedMethod& method,
               const RenderArguments& arguments) {
  RunStatistics run;
  run.software = "swept " SWEPT_VERSION;
  run.scene = arguments.scene;
  run.method = arguments.method->method;
  run.picture = picture_of(arguments, method);
  run.layers = *arguments.layers;
  run.layer_control.threads = arguments.control.threads;
  run.pixels = arguments.half ? ExrPixels::float16 : ExrPixels::float32;
  run.width = file.scene().film.width;
  run.height = file.scene().film.height;
  run.options = method.options;
  // OpenEXR compresses on threads of its own, which a process has to ask for.
  const int threads = run.layer_control.threads > 0 ? run.layer_control.threads
                                                    : static_cast<int>(std::thread::hardware_concurrency());
  Imf::setGlobalThreadCount(threads > 1 ? threads : 0);
  RunMembers members(rendered(outputs));
  if (const Status status =
          render_frames(file, outputs, *method.renderer, run, !arguments.no_load_ahead,
                        [&](const Scene& scene) { return remarks_on(arguments, file, scene, members); });
      !status)
    return fail(status.error());
  if (arguments.stats.empty()) return 0;
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) == 0)
    run.peak_memory_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
  const Status written = write_file(arguments.stats, to_json(run));
  return written ? 0 : fail(written.error());
}

/// "3/16".
void parse_part(const std::string& text, RenderArguments& arguments) {
  int read = 0;
  const bool two = std::sscanf(text.c_str(), "%d/%d%n", &arguments.part, &arguments.parts, &read) == 2 &&
                   static_cast<std::size_t>(read) == text.size();
  if (!two || arguments.part < 1 || arguments.part > arguments.parts || arguments.parts > 65536)
    throw CLI::ValidationError("--part", "expected which of how many, as in 3/16: " + text);
}

/// The scene with one of the strips that the film is cut into as its crop.
Result<SceneFile> read_part(const RenderArguments& arguments, const Film& film) {
  if (film.crop_width > 0) throw CLI::ValidationError("--part", "goes without a crop");
  const auto row = [&](int part) {
    return static_cast<int>(static_cast<long long>(part) * film.height / arguments.parts);
  };
  const int from = row(arguments.part - 1), to = row(arguments.part);
  if (from == to)
    throw CLI::ValidationError("--part", fmt::format("has no row: the film has {}", film.height));
  SceneOverrides overrides = *arguments.overrides;
  overrides.fields["/film/crop"] = {0.0, static_cast<double>(from), static_cast<double>(film.width),
                                    static_cast<double>(to - from)};
  return read_scene_or_points(arguments.scene, overrides);
}

int render(const RenderArguments& arguments) {
  check_arguments(arguments);
  if (arguments.max_memory > 0)
    if (const Status limited = limit_memory(arguments.max_memory); !limited) return fail(limited.error());
  MethodChoice choice = *arguments.method;
  choice.arguments.expect_error = arguments.layers->error;
  choice.arguments.expect_deep = !arguments.deep.empty();
  const Result<PreparedMethod> method = prepare_method(choice, arguments.control);
  if (!method) throw CLI::ValidationError(method.error().field, method.error().reason);
  std::vector<double> frames(arguments.frames.begin(), arguments.frames.end());
  // What the command line alone gets wrong is found without the scene.
  if (frames.size() > 1) {
    const auto named = name_outputs(frames, arguments.output, arguments.preview, arguments.deep);
    if (!named) return fail(named.error(), 2);
  }
  Result<SceneFile> file = read_scene_or_points(arguments.scene, *arguments.overrides);
  if (file && arguments.parts > 0) file = read_part(arguments, file->scene().film);
  if (!file) return report_scene_error("render", file.error(), *arguments.overrides);
  if (const Status fits =
          check_frame_memory(file->scene().film, *arguments.layers, memory_left(arguments.max_memory));
      !fits)
    return fail({arguments.scene, fits.error().field, fits.error().reason, fits.error().kind});
  if (frames.empty()) frames.push_back(file->scene().frame);
  Result<std::vector<FrameOutput>> outputs =
      name_outputs(frames, arguments.output, arguments.preview, arguments.deep);
  if (!outputs) return fail(outputs.error(), 2);
  const Existing existing = arguments.overwrite       ? Existing::overwrite
                            : arguments.skip_existing ? Existing::skip
                                                      : Existing::refuse;
  const auto origin_of = [&](const FrameOutput& output) -> Result<ExrOrigin> {
    Result<std::string> hash = file->hash(output.frame);
    if (!hash) return hash.error();
    return ExrOrigin{std::move(*hash), picture_of(arguments, *method)};
  };
  if (const Status status = check_outputs(*outputs, existing, origin_of); !status)
    return fail(status.error());
  if (const Status status = check_inputs_stay(*file, *outputs, arguments); !status)
    return fail(status.error());
  if (!arguments.stats.empty())
    if (const Status status = check_output_file(arguments.stats, existing); !status)
      return fail(status.error());
  return arguments.dry_run ? dry_run(*file, *outputs, arguments)
                           : render_all(*file, *outputs, *method, arguments);
}

}  // namespace

void add_render_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command = app.add_subcommand("render", "Render frames of a scene file to OpenEXR");
  command->footer(
      std::string("Examples:\n"
                  "  swept render scene.json -o f.%04d.exr --frames 1-48 --skip-existing   go on where a run "
                  "stopped\n"
                  "  swept render cloud.ply -o cloud.exr --preview cloud.png   the points as they are\n"
                  "  swept render scene.json -o small.exr --preview small.png --size 320x180\n\n") +
      exit_codes_help);
  command
      ->add_option("scene", arguments->scene,
                   "The scene file, or the points alone: a point file, or numbered ones as anim.%04d.ply")
      ->required()
      ->type_name("SCENE");
  command
      ->add_option("-o,--output", arguments->output,
                   "Where to write; for several frames with a number pattern in the file's name, such as "
                   "frame.%04d.exr, frame.####.exr or frame.$F4.exr")
      ->type_name("FILE.exr");
  command
      ->add_option("--preview", arguments->preview,
                   "Write an sRGB preview too, with a pattern as for --output")
      ->type_name("FILE.png");
  command
      ->add_option("--deep", arguments->deep,
                   "Write a deep EXR too, of what is seen at which depth, with a pattern as for --output; "
                   "with --exact")
      ->type_name("FILE.exr");
  command
      ->add_option_function<std::string>(
          "--frames",
          [arguments](const std::string& text) {
            const Result<std::vector<int>> frames = parse_frame_ranges(text);
            if (!frames) throw CLI::ValidationError("--frames", frames.error().reason);
            arguments->frames = *frames;
          },
          "Frames to render, e.g. 1-100x2,120; by default the scene's own")
      ->type_name("RANGES");
  command
      ->add_option_function<std::string>(
          "--part", [arguments](const std::string& text) { parse_part(text, *arguments); },
          "Render the I-th of N strips of the film, from the top; swept stitch puts them together")
      ->type_name("I/N");
  command->add_flag("--half", arguments->half,
                    "Write colours and alpha as half floats: 11 bits, 65504 at most; depth stays float");
  arguments->layers = add_layer_options(*command);
  auto* overwrite = command->add_flag("--overwrite", arguments->overwrite, "Replace files that exist");
  command
      ->add_flag("--skip-existing", arguments->skip_existing,
                 "Leave out frames that exist; a file that is not just that frame of this scene is an "
                 "error, and stays")
      ->excludes(overwrite);
  command->add_flag("--no-load-ahead", arguments->no_load_ahead,
                    "Load a frame of a sequence when the one before it is done, not while it is rendered: "
                    "takes less memory");
  command->add_flag("--dry-run", arguments->dry_run,
                    "Read everything, check the outputs, print the plan and render nothing");
  command->add_option("--threads", arguments->control.threads, "Threads; 0 takes all, and none changes a bit")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command
      ->add_option(
          "--max-memory", arguments->max_memory,
          "Memory that the process may take, as 4G or 512M; a frame that would take more is an error [all "
          "there is]")
      ->transform(CLI::AsSizeValue(false))
      ->transform(CLI::Validator(
          [](std::string& text) {
            // Read as an unsigned number, it would be nearly all there is. Of transforms the last is first.
            return text.find('-') == std::string::npos ? std::string() : "must not be negative: " + text;
          },
          ""))
      ->type_name("SIZE");
  command->add_option("--stats-json", arguments->stats, "Write counts and times of every frame")
      ->type_name("FILE.json");
  arguments->method = add_method_options(*command);
  arguments->overrides = add_scene_options(*command);
  command->callback([arguments, &exit_code] { exit_code = render(*arguments); });
}

}  // namespace swept
