// Accuracy against CPU time of the sampled engine: what it takes to 45 … 80 dB, and what --max-error takes
// and reaches.
//
// Usage: swept_engine_benchmark FOLDER [--threads N] [--reference N] [--scenes NAME,…] [--files SCENE.json,…]
//                               [--abuffer] [--rays N] [--random N] [--first-random K] [--points N]
// FOLDER keeps the reference images, and is used again. Times are CPU seconds of the process, all threads
// together. --random takes so many scenes that nobody chose instead, and counts how often what was asked for
// is reached. --points tells instead how time grows from 10⁴ points to so many.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "abuffer/abuffer.h"
#include "abuffer/sampled.h"
#include "datasets/generators.h"
#include "splat/compare/metrics.h"
#include "splat/io/image_file.h"
#include "splat/io/scene_file.h"
#include "tools/cpu_seconds.h"
#include "tools/engine_points.h"
#include "tools/engine_scenes.h"
#include "tools/study/raycast.h"

namespace swept {
namespace {

struct Timed {
  double seconds = 0.0, psnr_db = 0.0, expected_db = 0.0, instants = 0.0, prepared = 0.0;
};

Result<Timed> timed(const Scene& scene, const SampledOptions& options, const RenderControl& control,
                    const Image* reference) {
  const double start = cpu_seconds();
  const Result<Rendered> rendered = render_sampled(scene, options, control);
  Timed result;
  result.seconds = cpu_seconds() - start;
  if (!rendered) return rendered.error();
  result.instants = rendered->statistics.counter("instants_per_pixel").value_or(0.0);
  result.expected_db = rendered->statistics.counter("expected_psnr_db").value_or(0.0);
  for (const auto& [stage, seconds] : rendered->statistics.seconds)
    if (stage != "cells") result.prepared += seconds;
  if (reference != nullptr) {
    const auto metrics = compare_images(rendered->image, *reference);
    if (!metrics) return metrics.error();
    result.psnr_db = metrics->psnr_db;
  }
  return result;
}

/// Time at which a curve of (dB, log time) reaches `db`; nothing beyond its ends.
std::optional<double> time_to(const std::vector<Timed>& curve, double db) {
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const Timed &a = curve[i - 1], &b = curve[i];
    if (!(a.psnr_db < db && b.psnr_db >= db)) continue;
    const double t = (db - a.psnr_db) / (b.psnr_db - a.psnr_db);
    return std::exp(std::log(a.seconds) + t * (std::log(b.seconds) - std::log(a.seconds)));
  }
  return std::nullopt;
}

/// What asking for an error came to, over all scenes.
struct Asked {
  int scenes = 0, met = 0;
  double worst_db = 1e9;   ///< reached less asked
  double log_ratio = 0.0;  ///< of time to that of the cheapest number of instants for the whole film
  int ratios = 0;
};
std::map<double, Asked> asked_for;

struct Others {
  bool abuffer = false;
  int rays = 0;  ///< of Embree a pixel; 0: none
};

/// What another renderer takes and reaches, and that time over the engine's to the same PSNR.
template <class Render>
void print_other(const Render& render, const Image& reference, const std::vector<Timed>& curve) {
  const double start = cpu_seconds();
  const Result<Rendered> rendered = render();
  const double seconds = cpu_seconds() - start;
  if (!rendered) return fmt::print(" {} |", rendered.error().message());
  const auto metrics = compare_images(rendered->image, reference);
  const double db = metrics ? metrics->psnr_db : 0.0;
  const auto same = time_to(curve, db);
  const std::string ratio = same ? fmt::format(", {:.1f}", seconds / *same) : "";
  const auto sixty = time_to(curve, 60.0);
  fmt::print(" {:.1f} dB, {:.2f} s{}{} |", db, seconds, ratio,
             sixty ? fmt::format(", {:.1f}", seconds / *sixty) : std::string());
}

int run_scene(const std::string& name, const Scene& scene, const std::string& folder, int reference_instants,
              const RenderControl& control, const Others& others) {
  const std::string path = fmt::format("{}/{}-{}.exr", folder, name, reference_instants);
  Result<Image> reference = read_exr(path);
  if (!reference) {
    SampledOptions many;
    many.samples = reference_instants;
    Result<Rendered> rendered = render_sampled(scene, many);
    if (!rendered) return fmt::print(stderr, "{}: {}\n", name, rendered.error().message()), 1;
    if (Status written = write_exr(path, rendered->image); !written)
      return fmt::print(stderr, "{}\n", written.error().message()), 1;
    reference = std::move(rendered->image);
  }
  Scene closed = scene;
  closed.shutter.open = closed.shutter.close = 0.5 * (scene.shutter.open + scene.shutter.close);
  SampledOptions one;
  one.samples = 1;
  // The first warms up.
  Result<Timed> still = timed(closed, one, control, nullptr);
  if (still) still = timed(closed, one, control, nullptr);
  if (!still) return fmt::print(stderr, "{}: {}\n", name, still.error().message()), 1;

  std::vector<Timed> curve;
  for (int n = 1; n <= reference_instants / 4; n = n < 2                ? n + 1
                                                   : (n & (n - 1)) == 0 ? n * 3 / 2
                                                                        : n / 3 * 4) {
    SampledOptions options;
    options.samples = n;
    const Result<Timed> point = timed(scene, options, control, &*reference);
    if (!point) return fmt::print(stderr, "{}: {}\n", name, point.error().message()), 1;
    curve.push_back(*point);
    if (point->psnr_db > 82.0) break;
  }
  fmt::print("| {} | {:.3f} | {:.3f} |", name, still->seconds, still->prepared);
  for (const double db : {45.0, 50.0, 60.0, 70.0, 80.0}) {
    const auto seconds = time_to(curve, db);
    if (seconds)
      fmt::print(" {:.2f} |", *seconds);
    else
      fmt::print(" {} |", curve.front().psnr_db >= db ? fmt::format("<{:.2f}", curve.front().seconds) : "-");
  }
  for (const double db : {45.0, 60.0, 75.0}) {
    SampledOptions options;
    options.max_error_db = db;
    const Result<Timed> point = timed(scene, options, control, &*reference);
    if (!point) return fmt::print(stderr, "{}: {}\n", name, point.error().message()), 1;
    const auto uniform = time_to(curve, db);
    Asked& asked = asked_for[db];
    ++asked.scenes;
    asked.met += point->psnr_db >= db ? 1 : 0;
    asked.worst_db = std::min(asked.worst_db, point->psnr_db - db);
    if (uniform) ++asked.ratios, asked.log_ratio += std::log(point->seconds / *uniform);
    fmt::print(" {:.1f} ({:.1f}), {:.2f} s, {:.1f}{} |", point->psnr_db, point->expected_db, point->seconds,
               point->instants, uniform ? fmt::format(", {:.2f}", point->seconds / *uniform) : "");
  }
  if (others.abuffer) {
    print_other([&] { return render_abuffer(scene, {}, control); }, *reference, curve);
  }
  if (others.rays > 0) {
    RaycastOptions rays;
    rays.samples = others.rays;
    rays.threads = control.threads;
    print_other([&] { return render_raycast(scene, rays); }, *reference, curve);
  }
  fmt::print("\n");
  std::fflush(stdout);
  return 0;
}

int run(int argc, char** argv) {
  CLI::App app("Accuracy against CPU time of the sampled engine");
  std::string folder;
  RenderControl control;
  control.threads = 1;
  int reference_instants = 1024;
  std::vector<std::string> names = engine_scene_names(), files;
  app.add_option("folder", folder, "Where reference images are kept")->required();
  app.add_option("--threads", control.threads);
  app.add_option("--reference", reference_instants, "Instants of a reference image");
  app.add_option("--scenes", names)->delimiter(',');
  app.add_option("--files", files, "Scene files, besides")->delimiter(',');
  Others others;
  app.add_flag("--abuffer", others.abuffer, "The A-buffer too");
  int random = 0, first_random = 1;
  app.add_option("--random", random, "So many scenes that nobody chose, instead");
  app.add_option("--first-random", first_random, "Number of the first of them");
  app.add_option("--rays", others.rays, "Embree too, with so many rays a pixel");
  std::size_t points = 0;
  app.add_option("--points", points, "How time grows with the points, up to so many, instead");
  CLI11_PARSE(app, argc, argv);
  if (points > 0) return print_times_by_points(points, control);
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  std::string columns;
  if (others.abuffer) columns += " A-buffer: dB, s, to the engine at that dB, at 60 |";
  if (others.rays > 0) columns += fmt::format(" {} rays: the same |", others.rays);
  fmt::print(
      "| scene | still, s | of it before the cells | 45 dB | 50 | 60 | 70 | 80 | asked for 45: dB "
      "(expected), s, instants a "
      "pixel, to uniform | 60 | 75 |{}\n|---|---|---|---|---|---|---|---|---|---|---|{}\n",
      columns, (others.abuffer ? std::string("---|") : std::string()) + (others.rays > 0 ? "---|" : ""));
  int failed = 0;
  if (random > 0) names.clear();
  for (int k = 0; k < random; ++k) names.push_back(fmt::format("random-{}", first_random + k));
  for (const std::string& name : names) {
    if (name == "none") continue;
    const Result<EngineScene> made = make_engine_scene(name);
    if (!made) return fmt::print(stderr, "{}\n", made.error().message()), 2;
    failed |= run_scene(name, made->scene, folder, reference_instants, control, others);
  }
  for (const std::string& path : files) {
    Result<SceneFile> file = read_scene_file(path);
    if (!file) return fmt::print(stderr, "{}\n", file.error().message()), 2;
    const Result<const Scene*> scene = file->scene_at(file->scene().frame, generate);
    if (!scene) return fmt::print(stderr, "{}\n", scene.error().message()), 2;
    failed |= run_scene(std::filesystem::path(path).stem().string(), **scene, folder, reference_instants,
                        control, others);
  }
  for (const auto& [db, asked] : asked_for)
    fmt::print(
        "Asked for {} dB: met by {} of {} scenes, the worst by {:+.1f} dB; {:.2f} times the cheapest "
        "uniform instants (geometric mean of {})\n",
        db, asked.met, asked.scenes, asked.worst_db, std::exp(asked.log_ratio / std::max(1, asked.ratios)),
        asked.ratios);
  return failed;
}

}  // namespace
}  // namespace swept

int main(int argc, char** argv) { return swept::run(argc, argv); }
