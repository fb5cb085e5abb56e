#include "tools/render_command.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <sys/resource.h>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/supersample.h"
#include "datasets/generators.h"
#include "splat/io/atomic_file.h"
#include "splat/io/scene_file.h"
#include "splat/io/sequence.h"
#include "tools/gpu_method.h"
#include "tools/outputs.h"
#include "tools/render_frames.h"
#include "tools/scene_options.h"
#include "tools/stats_json.h"

namespace swept {
namespace {

struct RenderArguments {
  std::string scene, output, preview, stats;
  std::string method = "abuffer", motion = "segments", normalisation = "interval";
  std::vector<int> frames;  ///< empty: the scene's own
  std::optional<int> samples, subframes;
  std::string gpu;
  bool lookup_tables = false, clamp_motion = false, motion_given = false, normalisation_given = false,
       overwrite = false, skip_existing = false, dry_run = false;
  int threads = 0;
  std::shared_ptr<const SceneOverrides> overrides;
};

/// A renderer with its options filled in.
struct Method {
  std::shared_ptr<FrameRenderer> renderer;
  std::vector<std::pair<std::string, double>> options;
  std::string description;  ///< what of method and options is in the image
};

/// Options of a method other than the chosen one.
void check_method_options(const RenderArguments& arguments) {
  const auto check = [&](const char* option, bool given, const char* methods, bool goes) {
    if (given && !goes) throw CLI::ValidationError(option, fmt::format("goes with --method {}", methods));
  };
  const bool reference = arguments.method == "reference", six_pass = arguments.method == "gpu";
  const bool gpu = six_pass || arguments.method == "gpu-still";
  check("--normalisation", arguments.normalisation_given, "abuffer", arguments.method == "abuffer");
  check("--samples", arguments.samples.has_value(), "reference or cpu-still",
        reference || arguments.method == "cpu-still");
  check("--reference-motion", arguments.motion_given, "reference", reference);
  check("--subframes", arguments.subframes.has_value(), "gpu or gpu-still", gpu);
  check("--gpu", !arguments.gpu.empty(), "gpu or gpu-still", gpu);
  check("--lookup-tables", arguments.lookup_tables, "gpu", six_pass);
  check("--clamp-motion", arguments.clamp_motion, "gpu", six_pass);
}

Method choose_gpu_method(const RenderArguments& arguments) {
  GpuChoice choice;
  choice.still_frames = arguments.method == "gpu-still";
  choice.subframes = arguments.subframes.value_or(0);
  choice.lookup_tables = arguments.lookup_tables;
  choice.clamp_motion = arguments.clamp_motion;
  choice.device = arguments.gpu;
  return {gpu_frames(choice),
          {{"subframes", choice.subframes},
           {"lookup_tables", choice.lookup_tables ? 1 : 0},
           {"clamp_motion", choice.clamp_motion ? 1 : 0}},
          fmt::format("{} {}{}{}", arguments.method, choice.subframes, choice.lookup_tables ? " tables" : "",
                      choice.clamp_motion ? " clamped" : "")};
}

Method choose_method(const RenderArguments& arguments) {
  check_method_options(arguments);
  if (arguments.method == "gpu" || arguments.method == "gpu-still") return choose_gpu_method(arguments);
  if (arguments.method == "abuffer") {
    AbufferOptions options;
    options.threads = arguments.threads;
    const bool per_pixel = arguments.normalisation == "pixel";
    options.normalisation = per_pixel ? Normalisation::pixel : Normalisation::interval;
    return {
        std::make_shared<OneByOne>([options](const Scene& scene) { return render_abuffer(scene, options); }),
        {{"threads", options.threads}, {"normalisation_per_pixel", per_pixel ? 1 : 0}},
        per_pixel ? "abuffer, normalised per pixel" : "abuffer"};
  }
  if (arguments.method == "cpu-still") {
    SupersampleOptions options;
    options.threads = arguments.threads;
    options.samples = arguments.samples.value_or(options.samples);
    if (const Status valid = options.validate(); !valid)
      throw CLI::ValidationError("--samples", valid.error().reason);
    return {std::make_shared<OneByOne>(
                [options](const Scene& scene) { return render_supersampled(scene, options); }),
            {{"threads", options.threads}, {"samples", options.samples}},
            fmt::format("cpu-still {}", options.samples)};
  }
  ReferenceOptions options;
  options.threads = arguments.threads;
  options.samples = arguments.samples.value_or(options.samples);
  options.motion = arguments.motion == "smooth" ? ReferenceMotion::smooth : ReferenceMotion::segments;
  if (const Status valid = options.validate(); !valid)
    throw CLI::ValidationError("--samples", valid.error().reason);
  return {
      std::make_shared<OneByOne>([options](const Scene& scene) { return render_reference(scene, options); }),
      {{"threads", options.threads}, {"samples", options.samples}},
      fmt::format("reference {} {}", options.samples, arguments.motion)};
}

int fail(const Error& error, int exit_code = 1) {
  fmt::print(stderr, "swept render: {}\n", error.message());
  return exit_code;
}

/// Loads what the frames need and prints what would be done with them.
int dry_run(SceneFile& file, const std::vector<FrameOutput>& outputs) {
  for (const FrameOutput& output : outputs) {
    const std::string name = output.image.empty() ? "" : " " + output.image;
    if (output.skip) {
      fmt::print("frame {}: skip{}\n", output.frame, name);
      continue;
    }
    const Result<const Scene*> scene = file.scene_at(output.frame, generate);
    if (!scene) return fail(scene.error());
    std::size_t points = 0;
    for (const Object& object : (*scene)->objects) points += object.cloud.size();
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
  check_extension("--output", arguments.output, ".exr");
  check_extension("--preview", arguments.preview, ".png");
  check_extension("--stats-json", arguments.stats, ".json");
}

/// The statistics must not replace the scene they are about.
Status check_stats_path(const RenderArguments& arguments, Existing existing) {
  std::error_code code;
  if (std::filesystem::equivalent(arguments.stats, arguments.scene, code))
    return Error{arguments.stats, "--stats-json", "is the scene file"};
  return check_output_file(arguments.stats, existing);
}

int render_all(SceneFile& file, const std::vector<FrameOutput>& outputs, const Method& method,
               const RenderArguments& arguments) {
  RunStatistics run;
  run.software = "swept " SWEPT_VERSION;
  run.scene = arguments.scene;
  run.method = arguments.method;
  run.picture = method.description;
  run.width = file.scene().film.width;
  run.height = file.scene().film.height;
  run.options = method.options;
  if (const Status status = render_frames(file, outputs, *method.renderer, run); !status)
    return fail(status.error());
  if (arguments.stats.empty()) return 0;
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) == 0)
    run.peak_memory_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
  const Status written = write_file(arguments.stats, to_json(run));
  return written ? 0 : fail(written.error());
}

int render(const RenderArguments& arguments) {
  check_arguments(arguments);
  const Method method = choose_method(arguments);
  std::vector<double> frames(arguments.frames.begin(), arguments.frames.end());
  // What the command line alone gets wrong is found without the scene.
  if (frames.size() > 1) {
    const auto named = name_outputs(frames, arguments.output, arguments.preview);
    if (!named) return fail(named.error(), 2);
  }
  Result<SceneFile> file = read_scene_file(arguments.scene, *arguments.overrides);
  if (!file) return report_scene_error("render", file.error(), *arguments.overrides);
  if (frames.empty()) frames.push_back(file->scene().frame);
  Result<std::vector<FrameOutput>> outputs = name_outputs(frames, arguments.output, arguments.preview);
  if (!outputs) return fail(outputs.error(), 2);
  const Existing existing = arguments.overwrite       ? Existing::overwrite
                            : arguments.skip_existing ? Existing::skip
                                                      : Existing::refuse;
  const auto origin_of = [&](const FrameOutput& output) -> Result<ExrOrigin> {
    Result<std::string> hash = file->hash(output.frame);
    if (!hash) return hash.error();
    return ExrOrigin{std::move(*hash), method.description};
  };
  if (const Status status = check_outputs(*outputs, existing, origin_of); !status)
    return fail(status.error());
  if (!arguments.stats.empty())
    if (const Status status = check_stats_path(arguments, existing); !status) return fail(status.error());
  return arguments.dry_run ? dry_run(*file, *outputs) : render_all(*file, *outputs, method, arguments);
}

}  // namespace

void add_render_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command = app.add_subcommand("render", "Render frames of a scene file to OpenEXR");
  command->add_option("scene", arguments->scene, "The scene file")->required()->type_name("FILE.json");
  command
      ->add_option("-o,--output", arguments->output,
                   "Where to write; for several frames with a number pattern, frame.%04d.exr or "
                   "frame.####.exr")
      ->type_name("FILE.exr");
  command
      ->add_option("--preview", arguments->preview,
                   "Write an sRGB preview too, with a pattern as for --output")
      ->type_name("FILE.png");
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
  auto* overwrite = command->add_flag("--overwrite", arguments->overwrite, "Replace files that exist");
  command->add_flag("--skip-existing", arguments->skip_existing, "Leave out frames that exist")
      ->excludes(overwrite);
  command->add_flag("--dry-run", arguments->dry_run,
                    "Read everything, check the outputs, print the plan and render nothing");
  command
      ->add_option(
          "--method", arguments->method,
          "The exact A-buffer, still images averaged, the six passes on a GPU, still images averaged "
          "there, or the slow reference")
      ->check(CLI::IsMember({"abuffer", "cpu-still", "gpu", "gpu-still", "reference"}))
      ->capture_default_str();
  const auto* normalisation =
      command
          ->add_option("--normalisation", arguments->normalisation,
                       "What the A-buffer divides weights by: those of every visible interval, or once per "
                       "pixel, as Heinzle et al. 2010 do, which is another image")
          ->check(CLI::IsMember({"interval", "pixel"}))
          ->capture_default_str();
  command->add_option("--samples", arguments->samples,
                      "Still images that are averaged [cpu-still: 16; reference: 256, even]");
  const auto* motion =
      command
          ->add_option("--reference-motion", arguments->motion,
                       "What the reference moves the points along: the linear segments, or the true path")
          ->check(CLI::IsMember({"segments", "smooth"}))
          ->capture_default_str();
  command
      ->add_option(
          "--subframes", arguments->subframes,
          "Parts of the exposure that the GPU modes draw one by one; 0 chooses them from the motion [0]")
      ->check(CLI::Range(0, 65536));
  command
      ->add_option(
          "--gpu", arguments->gpu,
          "Device of the GPU modes, as `swept info --gpus` lists them; else the environment variable "
          "SWEPT_GPU, else the first that works")
      ->type_name("DEVICE");
  command->add_flag("--lookup-tables", arguments->lookup_tables,
                    "Six passes: take exp and erf from tables instead of computing them");
  command->add_flag("--clamp-motion", arguments->clamp_motion,
                    "Six passes: bend motion out of the discs' planes, as a matrix inverse would need it");
  command->add_option("--threads", arguments->threads, "Threads; 0 takes all, and none changes a bit")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option("--stats-json", arguments->stats, "Write counts and times of every frame")
      ->type_name("FILE.json");
  arguments->overrides = add_scene_options(*command);
  command->callback([arguments, motion, normalisation, &exit_code] {
    arguments->normalisation_given = normalisation->count() > 0;
    arguments->motion_given = motion->count() > 0;
    exit_code = render(*arguments);
  });
}

}  // namespace swept
