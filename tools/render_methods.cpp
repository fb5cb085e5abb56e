#include "tools/render_methods.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "abuffer/stochastic/stochastic.h"
#include "tools/gpu_method.h"

namespace swept {
namespace {

#ifdef SWEPT_HAS_GPU
constexpr bool gpu_built = true;
#else
constexpr bool gpu_built = false;
#endif

Result<PreparedMethod> prepare_abuffer(const MethodArguments& arguments, const RenderControl& control) {
  AbufferOptions options;
  const bool per_pixel = arguments.text("--normalisation", "interval") == "pixel";
  options.normalisation = per_pixel ? Normalisation::pixel : Normalisation::interval;
  options.deep = arguments.expect_deep;
  options.place_intervals = static_cast<std::size_t>(arguments.whole("--place-intervals", 0));
  const bool both_ends = arguments.text("--back-faces", "exact") == "both-ends";
  options.back_faces = both_ends ? BackFaces::both_ends : BackFaces::exact;
  if (options.deep && per_pixel)
    return Error{"", "--deep", "has every interval's own colours: it goes with --normalisation interval"};
  std::string name = per_pixel ? "abuffer, normalised per pixel" : "abuffer";
  if (options.place_intervals > 0)
    name = fmt::format("{}, {} intervals a place", name, options.place_intervals);
  if (both_ends) name += ", back faces at both ends";
  return PreparedMethod{std::make_shared<OneByOne>(
                            [options](const Scene& scene, const RenderControl& within) {
                              return render_abuffer(scene, options, within);
                            },
                            control),
                        {{"threads", control.threads},
                         {"normalisation_per_pixel", per_pixel ? 1 : 0},
                         {"place_intervals", static_cast<double>(options.place_intervals)},
                         {"back_faces_at_both_ends", both_ends ? 1 : 0}},
                        name};
}

/// A PSNR as in 60dB, or a root mean square error below 1, as PSNR.
Result<double> error_db(const MethodArguments& arguments, const char* option, double otherwise) {
  if (!arguments.given(option)) return otherwise;
  const std::string text = arguments.text(option, "");
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  std::string unit(end, text.data() + text.size());
  for (char& c : unit) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (code == std::errc() && unit == "db" && value > 0.0 && value <= 150.0) return value;
  if (code == std::errc() && unit.empty() && value > 0.0 && value < 1.0) return -20.0 * std::log10(value);
  return Error{"", option,
               fmt::format("expected a PSNR up to 150dB, or a root mean square error below 1: {}", text)};
}

std::string sampled_picture(const SampledOptions& options) {
  if (options.samples > 0) return fmt::format("sampled {}", options.samples);
  if (options.max_seconds > 0.0) return fmt::format("sampled for {} s", options.max_seconds);
  std::string picture = fmt::format("sampled to {} dB", options.max_error_db);
  if (options.max_cell_error_db > 0.0) picture += fmt::format(", cells {}", options.max_cell_error_db);
  return picture;
}

Result<PreparedMethod> prepare_sampled(const MethodArguments& arguments, const RenderControl& control) {
  SampledOptions options;
  const Result<double> frame = error_db(arguments, "--max-error", options.max_error_db);
  if (!frame) return frame.error();
  const Result<double> cell = error_db(arguments, "--max-cell-error", options.max_cell_error_db);
  if (!cell) return cell.error();
  options.max_error_db = *frame;
  options.max_cell_error_db = *cell;
  options.samples = arguments.whole("--samples", options.samples);
  options.error_channel = arguments.expect_error;
  if (options.samples > 0 && (arguments.given("--max-error") || arguments.given("--max-cell-error")))
    return Error{"", "--samples", "says how many instants, and --max-error has them chosen: one of the two"};
  options.max_seconds = arguments.number("--max-seconds", 0.0);
  if (options.max_seconds > 0.0 &&
      (options.samples > 0 || arguments.given("--max-error") || arguments.given("--max-cell-error")))
    return Error{"", "--max-seconds", "goes with neither --max-error nor --samples: one of the three"};
  if (const Status valid = options.validate(); !valid)
    return Error{"", valid.error().field, valid.error().reason, valid.error().kind};
  return PreparedMethod{std::make_shared<OneByOne>(
                            [options](const Scene& scene, const RenderControl& within) {
                              return render_sampled(scene, options, within);
                            },
                            control),
                        {{"threads", control.threads},
                         {"samples", options.samples},
                         {"max_error_db", options.max_error_db},
                         {"max_cell_error_db", options.max_cell_error_db},
                         {"max_seconds", options.max_seconds}},
                        sampled_picture(options)};
}

Result<PreparedMethod> prepare_reference(const MethodArguments& arguments, const RenderControl& control) {
  ReferenceOptions options;
  options.samples = arguments.whole("--samples", options.samples);
  const std::string motion = arguments.text("--reference-motion", "smooth");
  options.motion = motion == "segments" ? ReferenceMotion::segments : ReferenceMotion::smooth;
  if (const Status valid = options.validate(); !valid)
    return Error{"", "--samples", valid.error().reason, valid.error().kind};
  return PreparedMethod{std::make_shared<OneByOne>(
                            [options](const Scene& scene, const RenderControl& within) {
                              return render_reference(scene, options, within);
                            },
                            control),
                        {{"threads", control.threads}, {"samples", options.samples}},
                        fmt::format("reference {} {}", options.samples, motion)};
}

Result<PreparedMethod> prepare_stochastic(const MethodArguments& arguments, const RenderControl& control) {
  StochasticOptions options;
  options.samples = arguments.whole("--samples", options.samples);
  const std::string traversal = arguments.text("--traversal", "auto");
  const std::size_t dash = traversal.find('-');
  const int number = dash == std::string::npos ? 0 : std::stoi(traversal.substr(dash + 1));
  if (traversal.starts_with("tile")) {
    options.traversal = Traversal::tile;
    options.tile_px = number;
  } else if (traversal.starts_with("interval")) {
    options.traversal = Traversal::interval;
    options.intervals = number;
  } else if (traversal == "hierarchy") {
    options.traversal = Traversal::hierarchy;
  } else if (traversal == "interleave") {
    options.traversal = Traversal::interleave;
  }
  const bool hulls = arguments.text("--tile-bounds", "slefes") == "hulls";
  options.bounds = hulls ? CurveBounds::hulls : CurveBounds::slefes;
  if (const Status valid = options.validate(); !valid)
    return Error{"", "--" + valid.error().field, valid.error().reason, valid.error().kind};
  return PreparedMethod{std::make_shared<OneByOne>(
                            [options](const Scene& scene, const RenderControl& within) {
                              return render_stochastic(scene, options, within);
                            },
                            control),
                        {{"threads", control.threads}, {"samples", options.samples}},
                        // The other traversals change no bit.
                        fmt::format("stochastic {}{}", options.samples,
                                    options.traversal == Traversal::interleave ? ", shared instants" : "")};
}

Result<PreparedMethod> prepare_gpu(const MethodArguments& arguments, bool still_frames) {
  GpuChoice choice;
  choice.still_frames = still_frames;
  choice.subframes = arguments.whole("--subframes", 0);
  choice.lookup_tables = arguments.given("--lookup-tables");
  choice.clamp_motion = arguments.given("--clamp-motion");
  choice.device = arguments.text("--gpu", "");
  return PreparedMethod{
      gpu_frames(choice),
      {{"subframes", choice.subframes},
       {"lookup_tables", choice.lookup_tables ? 1 : 0},
       {"clamp_motion", choice.clamp_motion ? 1 : 0}},
      fmt::format("{} {}{}{}", still_frames ? "gpu-still" : "gpu", choice.subframes,
                  choice.lookup_tables ? " tables" : "", choice.clamp_motion ? " clamped" : "")};
}

Result<PreparedMethod> prepare_six_pass(const MethodArguments& arguments, const RenderControl&) {
  return prepare_gpu(arguments, false);
}

Result<PreparedMethod> prepare_gpu_still(const MethodArguments& arguments, const RenderControl&) {
  return prepare_gpu(arguments, true);
}

/// Whether `text` is a number of the option's kind and range; else what is wrong with it.
std::string check_text(const MethodOption& option, const std::string& text) {
  using Kind = MethodOption::Kind;
  if (option.kind == Kind::word &&
      std::find(option.words.begin(), option.words.end(), text) == option.words.end())
    return fmt::format("{} is none of {}", text, fmt::join(option.words, ", "));
  if (option.kind != Kind::whole && option.kind != Kind::number) return "";
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return "expected a number, found " + text;
  if (option.kind == Kind::whole && value != std::floor(value))
    return "expected a whole number, found " + text;
  if (value < option.low || value > option.high)
    return fmt::format("must be between {} and {}: {}", option.low, option.high, text);
  return "";
}

const RenderMethod& find_method(std::string_view name) {
  const auto& methods = render_methods();
  return *std::find_if(methods.begin(), methods.end(),
                       [&](const RenderMethod& method) { return method.name == name; });
}

/// "sampled or reference".
std::string methods_with(std::string_view option) {
  std::string names;
  for (const RenderMethod& method : render_methods())
    if (std::find(method.options.begin(), method.options.end(), option) != method.options.end())
      (names += names.empty() ? "" : " or ") += method.name;
  return names;
}

std::string type_name_of(const MethodOption& option) {
  switch (option.kind) {
    case MethodOption::Kind::word:
      return fmt::format("{}", fmt::join(option.words, "|"));
    case MethodOption::Kind::text:
      return std::string(option.type_name);
    default:
      return "N";
  }
}

}  // namespace

const std::vector<RenderMethod>& render_methods() {
  static const std::vector<RenderMethod> methods = {
      {"sampled",
       "as many instants as the error asked for takes, cell by cell",
       {"--max-error", "--max-cell-error", "--max-seconds", "--samples"},
       true,
       prepare_sampled},
      {"abuffer",
       "the exact A-buffer",
       {"--normalisation", "--place-intervals", "--back-faces"},
       true,
       prepare_abuffer},
      {"gpu",
       "the six passes on a GPU",
       {"--subframes", "--gpu", "--lookup-tables", "--clamp-motion"},
       gpu_built,
       prepare_six_pass},
      {"gpu-still", "still images averaged on a GPU", {"--subframes", "--gpu"}, gpu_built, prepare_gpu_still},
      {"stochastic",
       "points in pixel, lens and time, at random",
       {"--samples", "--traversal", "--tile-bounds"},
       true,
       prepare_stochastic},
      {"reference", "the slow reference", {"--samples", "--reference-motion"}, true, prepare_reference}};
  return methods;
}

const std::vector<MethodOption>& method_options() {
  using Kind = MethodOption::Kind;
  static const std::vector<MethodOption> options = {
      {.name = "--max-error",
       .kind = Kind::text,
       .help = "How far the frame may be off: a PSNR for peak 1, or a root mean square error below 1 [60dB]",
       .type_name = "60dB|0.001",
       .example = "50dB"},
      {.name = "--max-cell-error",
       .kind = Kind::text,
       .help = "The same for every 64 x 64 px of it by themselves",
       .type_name = "60dB|0.001",
       .example = "50dB"},
      {.name = "--max-seconds",
       .kind = Kind::number,
       .help = "Seconds for a frame instead of an error: it is made as good as they allow, and says how good",
       .low = 0.001,
       .high = 1e9},
      {.name = "--normalisation",
       .kind = Kind::word,
       .help = "What the A-buffer divides weights by: those of every visible interval, or once per pixel, as "
               "Heinzle et al. 2010 do, which is another image [interval]",
       .words = {"interval", "pixel"}},
      {.name = "--place-intervals",
       .kind = Kind::whole,
       .help =
           "Keep so many intervals of time of triangles at each of a pixel's 16 places, and merge others by "
           "least error [all]",
       .low = 1,
       .high = 65536},
      {.name = "--back-faces",
       .kind = Kind::word,
       .help = "Which triangles of one-sided meshes are left out: those that face away, while they do, or "
               "for the whole exposure also those that do at both ends of it, as Rönnow et al. 2021 have it, "
               "which is another image [exact]",
       .words = {"exact", "both-ends"}},
      {.name = "--samples",
       .kind = Kind::whole,
       .help =
           "Instants that are averaged [sampled: as --max-error asks; reference: 256, even], or samples of a "
           "pixel [stochastic: 128]",
       .low = 1,
       .high = 1 << 20},
      {.name = "--reference-motion",
       .kind = Kind::word,
       .help = "What the reference moves the points along: the linear segments, or the true path [smooth]",
       .words = {"segments", "smooth"}},
      {.name = "--traversal",
       .kind = Kind::word,
       .help =
           "How samples are found that moving things may cover: by tiles of so many pixels, by parts of the "
           "exposure, by a hierarchy of moving boxes, or at 256 instants that samples share, which alone is "
           "another image; auto is tile-4 or interval-16, "
           "whichever a forecast has as the faster [auto]",
       .words = {"auto", "tile-1", "tile-2", "tile-4", "tile-8", "interval-4", "interval-16", "interval-64",
                 "hierarchy", "interleave"}},
      {.name = "--tile-bounds",
       .kind = Kind::word,
       .help = "What encloses moving edges in tiles; changes no bit [slefes]",
       .words = {"slefes", "hulls"}},
      {.name = "--subframes",
       .kind = Kind::whole,
       .help = "Parts of the exposure that the GPU draws one by one; 0 chooses them from the motion [0]",
       .low = 0,
       .high = 65536},
      {.name = "--gpu",
       .kind = Kind::text,
       .help = "Device, as `swept info --gpus` lists them; else the environment variable SWEPT_GPU, else the "
               "first that works",
       .type_name = "DEVICE"},
      {.name = "--lookup-tables", .help = "Take exp and erf from tables instead of computing them"},
      {.name = "--clamp-motion",
       .help = "Bend motion out of the discs' planes, as a matrix inverse would need it"}};
  return options;
}

double MethodArguments::number(std::string_view option, double otherwise) const {
  const auto found = texts_.find(option);
  if (found == texts_.end()) return otherwise;
  double value = otherwise;
  std::from_chars(found->second.data(), found->second.data() + found->second.size(), value);
  return value;
}

int MethodArguments::whole(std::string_view option, int otherwise) const {
  return static_cast<int>(number(option, otherwise));
}

std::string MethodArguments::text(std::string_view option, std::string_view otherwise) const {
  const auto found = texts_.find(option);
  return found == texts_.end() ? std::string(otherwise) : found->second;
}

std::vector<std::string> MethodArguments::options() const {
  std::vector<std::string> names;
  for (const auto& [name, text] : texts_) names.push_back(name);
  return names;
}

std::shared_ptr<const MethodChoice> add_method_options(CLI::App& command) {
  auto choice = std::make_shared<MethodChoice>();
  choice->method = render_methods().front().name;
  std::string help = "How to render";
  std::vector<std::string> names;
  for (const RenderMethod& method : render_methods()) {
    help += fmt::format("{} {}: {}{}", names.empty() ? ";" : ",", method.name, method.help,
                        method.built ? "" : " (not in this build)");
    names.emplace_back(method.name);
  }
  command.add_option("--method", choice->method, help)
      ->check(CLI::IsMember(names))
      ->capture_default_str()
      ->group("Method");
  command
      .add_flag_callback(
          "--exact", [choice] { choice->method = "abuffer"; }, "The exact image: --method abuffer")
      ->excludes("--method")
      ->group("Method");
  for (const MethodOption& option : method_options()) {
    const std::string name(option.name), help_text = fmt::format("{} ({})", option.help, methods_with(name));
    if (option.kind == MethodOption::Kind::flag) {
      command
          .add_flag_callback(
              name, [choice, name] { choice->arguments.give(name, ""); }, help_text)
          ->group("Method");
      continue;
    }
    command
        .add_option_function<std::string>(
            name, [choice, name](const std::string& text) { choice->arguments.give(name, text); }, help_text)
        ->check([&option](const std::string& text) { return check_text(option, text); })
        ->type_name(type_name_of(option))
        ->group("Method");
  }
  return choice;
}

Result<PreparedMethod> prepare_method(const MethodChoice& choice, const RenderControl& control) {
  const RenderMethod& method = find_method(choice.method);
  RenderControl within = control;
  // More threads than cores gain nothing, and oneTBB says so on stderr.
  if (const auto cores = static_cast<int>(std::thread::hardware_concurrency()); cores > 0)
    within.threads = std::min(within.threads, cores);
  for (const std::string& option : choice.arguments.options())
    if (std::find(method.options.begin(), method.options.end(), option) == method.options.end())
      return Error{"", option, "goes with --method " + methods_with(option)};
  return method.prepare(choice.arguments, within);
}

}  // namespace swept
