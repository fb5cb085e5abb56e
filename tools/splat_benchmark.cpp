// What a picture of trained Gaussian splats costs: sixteen stills, and a blurred frame at the error asked
// for.
//
// Usage: swept_splat_benchmark FILE [--size 256 256] [--threads N] [--max-error 60] [--truth N] [--reference]
// The file may be a scene, or splats alone, which are framed as `swept render` frames them; the camera then
// passes them sideways. Times are CPU seconds of the process, all threads together.
#include <cstdio>
#include <string>

#include <sys/resource.h>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "abuffer/reference/splat_reference.h"
#include "abuffer/sampled.h"
#include "datasets/generators.h"
#include "splat/compare/metrics.h"
#include "splat/io/cloud_scene.h"
#include "splat/io/scene_file.h"
#include "tools/cpu_seconds.h"

namespace swept {
namespace {

struct Arguments {
  std::string file;
  double max_error_db = 60.0;
  int truth = 256;
  bool reference = false;
  RenderControl control;
  SceneOverrides overrides;
};

struct Timed {
  Rendered rendered;
  double seconds = 0.0;
};

Result<Timed> timed(const Scene& scene, const SampledOptions& options, const RenderControl& control) {
  const double start = cpu_seconds();
  Result<Rendered> rendered = render_sampled(scene, options, control);
  if (!rendered) return rendered.error();
  return Timed{std::move(*rendered), cpu_seconds() - start};
}

SampledOptions samples(int count) {
  SampledOptions options;
  options.samples = count;
  return options;
}

/// The scene with its first look-at camera moving sideways by so many px of the film at its target.
Scene passing(const Scene& scene, double px) {
  Scene moved = scene;
  LookAtKey from = scene.camera.look_ats.front(), to = from;
  const Eigen::Vector3d view = from.target - from.eye;
  const double focal = projection_of(scene.film, from.tan_half_fov_y, from.lens).focal_px;
  const Eigen::Vector3d way = px / focal * view.norm() * view.cross(from.up).normalized();
  from.frame = scene.exposure().open;
  to.frame = scene.exposure().close;
  to.eye += way, to.target += way;
  moved.camera.look_ats = {from, to};
  return moved;
}

double psnr_of(const Image& image, const Image& truth) {
  const auto metrics = compare_images(image, truth);
  return metrics ? metrics->psnr_db : 0.0;
}

/// What others are judged by: the engine's own mean of many instants, or that of the slow reference in
/// double.
Result<Rendered> truth_of(const Scene& scene, const Arguments& arguments) {
  if (!arguments.reference) return render_sampled(scene, samples(arguments.truth), arguments.control);
  return render_splat_reference(scene, {arguments.truth, 0}, arguments.control);
}

/// The least number of stills for the whole film that reaches the error asked for, by halving.
Result<int> cheapest(const Scene& scene, const Image& truth, const Arguments& arguments) {
  const auto enough = [&](int count) -> Result<bool> {
    const Result<Rendered> stills = render_sampled(scene, samples(count), arguments.control);
    if (!stills) return stills.error();
    return psnr_of(stills->image, truth) >= arguments.max_error_db;
  };
  int few = 0, many = 1;
  while (many < arguments.truth) {
    const Result<bool> is_enough = enough(many);
    if (!is_enough) return is_enough.error();
    if (*is_enough) break;
    few = many, many *= 2;
  }
  while (many - few > 1) {
    const int middle = few + (many - few) / 2;
    const Result<bool> is_enough = enough(middle);
    if (!is_enough) return is_enough.error();
    (*is_enough ? many : few) = middle;
  }
  return many;
}

Status row(const std::string& name, const Scene& scene, const Arguments& arguments) {
  SampledOptions asked;
  asked.max_error_db = arguments.max_error_db;
  const Result<Timed> stills = timed(scene, samples(16), arguments.control),
                      chosen = timed(scene, asked, arguments.control);
  for (const Result<Timed>* result : {&stills, &chosen})
    if (!*result) return result->error();
  const Result<Rendered> truth = truth_of(scene, arguments);
  if (!truth) return truth.error();
  const Result<int> least = cheapest(scene, truth->image, arguments);
  if (!least) return least.error();
  const auto psnr = [&](const Timed& of) { return psnr_of(of.rendered.image, truth->image); };
  const auto counter = [&](const char* what) {
    return chosen->rendered.statistics.counter(what).value_or(0.0);
  };
  fmt::print("| {} | {:.3f} | {:.1f} | {:.3f} | {:.1f} | {:.1f} | {:.1f} | {} |\n", name, stills->seconds,
             psnr(*stills), chosen->seconds, psnr(*chosen), counter("expected_psnr_db"),
             counter("instants_per_pixel"), *least);
  std::fflush(stdout);
  return Done{};
}

Status run(const Arguments& arguments) {
  Result<SceneFile> file = read_scene_or_points(arguments.file, arguments.overrides);
  if (!file) return file.error();
  const Result<const Scene*> scene = file->scene_at(file->scene().frame, generate);
  if (!scene) return scene.error();
  Scene still = **scene;
  still.shutter.close = still.shutter.open;
  const Result<Timed> one = timed(still, {}, arguments.control);
  if (!one) return one.error();
  if (arguments.reference) {
    const Result<Rendered> exact = render_splat_reference(still, {1, 0}, arguments.control);
    if (!exact) return exact.error();
    fmt::print("a still of the reference is matched to {:.1f} dB\n",
               psnr_of(one->rendered.image, exact->image));
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("{}: {} splats, {} x {} px, one still {:.3f} s, packed {:.0f} bytes a splat, peak {} MiB\n\n",
             arguments.file, one->rendered.statistics.counter("splats").value_or(0.0), still.film.width,
             still.film.height, one->seconds,
             one->rendered.statistics.counter("packed_bytes").value_or(0.0) /
                 std::max(1.0, one->rendered.statistics.counter("splats").value_or(0.0)),
             usage.ru_maxrss / 1024);
  fmt::print(
      "| motion | 16 stills, s | dB | to {} dB, s | reached, dB | expected | instants a pixel | cheapest for "
      "all |\n",
      arguments.max_error_db);
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  if (Status status = row("as the scene has it", **scene, arguments); !status) return status;
  if ((*scene)->camera.look_ats.empty()) return Done{};
  for (const double px : {10.0, 30.0, 100.0})
    if (Status status = row(fmt::format("camera sideways {} px", px), passing(**scene, px), arguments);
        !status)
      return status;
  return Done{};
}

}  // namespace
}  // namespace swept

int main(int argc, char** argv) {
  swept::Arguments arguments;
  arguments.overrides.fields["/film/width"] = {256.0};
  arguments.overrides.fields["/film/height"] = {256.0};
  CLI::App app("Times pictures of Gaussian splats");
  app.add_option("file", arguments.file, "Splats or a scene")->required();
  app.add_option_function<std::pair<double, double>>(
      "--size",
      [&](const std::pair<double, double>& size) {
        arguments.overrides.fields["/film/width"] = {size.first};
        arguments.overrides.fields["/film/height"] = {size.second};
      },
      "Width and height, px");
  app.add_option("--threads", arguments.control.threads, "At most so many");
  app.add_option("--max-error", arguments.max_error_db, "PSNR asked for, dB");
  app.add_flag("--reference", arguments.reference,
               "Compare with the slow reference in double, a still of it besides; takes minutes");
  app.add_option("--truth", arguments.truth, "Instants that others are compared with");
  CLI11_PARSE(app, argc, argv);
  if (const swept::Status status = swept::run(arguments); !status) {
    fmt::print(stderr, "swept_splat_benchmark: {}\n", status.error().message());
    return 1;
  }
  return 0;
}
