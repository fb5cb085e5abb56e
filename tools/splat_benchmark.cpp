// What a picture of trained Gaussian splats costs: sixteen stills, and a blurred frame at the error asked
// for.
//
// Usage: swept_splat_benchmark FILE [--size 256 256] [--threads N] [--max-error 60] [--truth N] [--reference]
// The file may be a scene, or splats alone, which are framed as `swept render` frames them; the camera then
// passes them sideways, goes around them and toward them, and splats fly apart. Times are CPU seconds of the
// process, all threads together. With --reference the judge is the slow one in double, of stills too: 1,024
// instants at 128 × 128 take minutes a row.
//
//        swept_splat_benchmark --random N [--first-random K] [--max-error 60] [--threads N] [--truth N]
// N scenes that nobody chose, from number K on, and what they take beside the cheapest number of instants for
// the whole film.
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <sys/resource.h>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include "abuffer/reference/splat_reference.h"
#include "abuffer/sampled.h"
#include "datasets/generators.h"
#include "splat/compare/metrics.h"
#include "splat/io/cloud_scene.h"
#include "splat/io/scene_file.h"
#include "tools/cpu_seconds.h"
#include "tools/random_splats.h"

namespace swept {
namespace {

struct Arguments {
  std::string file;
  double max_error_db = 60.0;
  int truth = 256;
  bool reference = false;
  int random = 0, first_random = 1;
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

/// How the first look-at camera of a scene may move, or its splats by themselves.
enum class Move { sideways, around, toward, apart };

/// The scene in motion by so many px of the film: at the camera's target if it passes; far behind that if it
/// goes around it; at the film's upper and lower edge if it goes toward it; in the mean if splats fly apart.
Scene in_motion(const Scene& scene, Move move, double px) {
  Scene moved = scene;
  LookAtKey from = scene.camera.look_ats.front(), to = from;
  const Eigen::Vector3d view = from.target - from.eye, right = view.cross(from.up).normalized();
  const double focal = projection_of(scene.film, from.tan_half_fov_y, from.lens).focal_px, angle = px / focal;
  from.frame = scene.exposure().open;
  to.frame = scene.exposure().close;
  switch (move) {
    case Move::sideways:
      to.eye += angle * view.norm() * right, to.target += angle * view.norm() * right;
      break;
    case Move::around:
      to.eye = to.target - std::cos(angle) * view + std::sin(angle) * view.norm() * right;
      break;
    case Move::toward:
      to.eye += view * (1.0 - 1.0 / (1.0 + px / (0.5 * scene.film.height)));
      break;
    case Move::apart: {
      std::mt19937 generator(7);
      std::normal_distribution<float> any;
      // The mean length of such a vector on the film is 1.25.
      const double length = angle * view.norm() / (1.25 * (to.frame - from.frame));
      for (Object& object : moved.objects)
        if (!object.splats.motion) {
          object.splats.velocity.clear();
          object.splats.frame = from.frame;
          for (std::size_t i = 0; i < object.splats.size(); ++i) {
            const float x = any(generator), y = any(generator), z = any(generator);
            object.splats.velocity.push_back((length * Eigen::Vector3d(x, y, z)).cast<float>());
          }
        }
      return moved;
    }
  }
  moved.camera.look_ats = {from, to};
  return moved;
}

double psnr_of(const Image& image, const Image& truth) {
  const auto metrics = compare_images(image, truth);
  return metrics ? metrics->psnr_db : 0.0;
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
  const Result<Rendered> truth = render_sampled(scene, samples(arguments.truth), arguments.control);
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

/// A still where the exposure ends, and the frame as it is asked for.
Status judged_row(const std::string& name, const Scene& scene, const Arguments& arguments) {
  Scene still = scene;
  still.shutter.open = still.shutter.close;
  SampledOptions asked;
  asked.max_error_db = arguments.max_error_db;
  const Result<Rendered> one = render_sampled(still, asked, arguments.control),
                         one_exact = render_splat_reference(still, {1, 0}, arguments.control),
                         blurred = render_sampled(scene, asked, arguments.control),
                         truth = render_splat_reference(scene, {arguments.truth, 0}, arguments.control);
  for (const Result<Rendered>* result : {&one, &one_exact, &blurred, &truth})
    if (!*result) return result->error();
  const auto counter = [&](const char* what) { return blurred->statistics.counter(what).value_or(0.0); };
  fmt::print("| {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n", name, psnr_of(one->image, one_exact->image),
             psnr_of(blurred->image, truth->image), counter("expected_psnr_db"),
             counter("instants_per_pixel"));
  std::fflush(stdout);
  return Done{};
}

Status run_random(const Arguments& arguments) {
  SampledOptions asked;
  asked.max_error_db = arguments.max_error_db;
  fmt::print(
      "| scene | splats | to {} dB: reached, dB | expected | instants a pixel | cheapest for all | time |\n"
      "|---|---|---|---|---|---|---|\n",
      arguments.max_error_db);
  double instants_log = 0.0, time_log = 0.0;
  int met = 0;
  for (int k = 0; k < arguments.random; ++k) {
    const int seed = arguments.first_random + k;
    const Scene scene = random_splat_scene(static_cast<unsigned>(seed));
    const Result<Timed> chosen = timed(scene, asked, arguments.control);
    if (!chosen) return chosen.error();
    const Result<Rendered> truth = render_sampled(scene, samples(arguments.truth), arguments.control);
    if (!truth) return truth.error();
    const Result<int> least = cheapest(scene, truth->image, arguments);
    if (!least) return least.error();
    const Result<Timed> best = timed(scene, samples(*least), arguments.control);
    if (!best) return best.error();
    const auto counter = [&](const char* what) {
      return chosen->rendered.statistics.counter(what).value_or(0.0);
    };
    const double reached = psnr_of(chosen->rendered.image, truth->image),
                 instants = counter("instants_per_pixel"), ratio = chosen->seconds / best->seconds;
    met += reached >= arguments.max_error_db ? 1 : 0;
    instants_log += std::log(instants / *least), time_log += std::log(ratio);
    fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.1f} | {} | {:.2f} |\n", seed, scene.objects[0].splats.size(),
               reached, counter("expected_psnr_db"), instants, *least, ratio);
    std::fflush(stdout);
  }
  fmt::print(
      "\nmet by {} of {}; in the geometric mean {:.2f} times the cheapest number's instants, {:.2f} times "
      "its time\n",
      met, arguments.random, std::exp(instants_log / arguments.random),
      std::exp(time_log / arguments.random));
  return Done{};
}

Status run(const Arguments& arguments) {
  if (arguments.random > 0) return run_random(arguments);
  Result<SceneFile> file = read_scene_or_points(arguments.file, arguments.overrides);
  if (!file) return file.error();
  const Result<const Scene*> scene = file->scene_at(file->scene().frame, generate);
  if (!scene) return scene.error();
  Scene still = **scene;
  still.shutter.close = still.shutter.open;
  const Result<Timed> one = timed(still, {}, arguments.control);
  if (!one) return one.error();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("{}: {} splats, {} x {} px, one still {:.3f} s, packed {:.0f} bytes a splat, peak {} MiB\n\n",
             arguments.file, one->rendered.statistics.counter("splats").value_or(0.0), still.film.width,
             still.film.height, one->seconds,
             one->rendered.statistics.counter("packed_bytes").value_or(0.0) /
                 std::max(1.0, one->rendered.statistics.counter("splats").value_or(0.0)),
             usage.ru_maxrss / 1024);
  const auto each_row = arguments.reference ? judged_row : row;
  if (arguments.reference)
    fmt::print(
        "| motion | still, dB | to {} dB: reached against {} instants, dB | expected | instants a pixel |\n"
        "|---|---|---|---|---|\n",
        arguments.max_error_db, arguments.truth);
  else
    fmt::print(
        "| motion | 16 stills, s | dB | to {} dB, s | reached, dB | expected | instants a pixel | cheapest "
        "for "
        "all |\n|---|---|---|---|---|---|---|---|\n",
        arguments.max_error_db);
  if (Status status = each_row("as the scene has it", **scene, arguments); !status) return status;
  if ((*scene)->camera.look_ats.empty()) return Done{};
  struct Row {
    const char* name;
    Move move;
    double px;
  };
  for (const Row& r :
       {Row{"camera sideways", Move::sideways, 10.0}, Row{"camera sideways", Move::sideways, 30.0},
        Row{"camera sideways", Move::sideways, 100.0}, Row{"camera around", Move::around, 30.0},
        Row{"camera around", Move::around, 100.0}, Row{"camera toward", Move::toward, 30.0},
        Row{"splats apart", Move::apart, 10.0}, Row{"splats apart", Move::apart, 30.0}})
    if (Status status =
            each_row(fmt::format("{} {} px", r.name, r.px), in_motion(**scene, r.move, r.px), arguments);
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
  auto* const file = app.add_option("file", arguments.file, "Splats or a scene");
  auto* const random =
      app.add_option("--random", arguments.random, "So many scenes that nobody chose instead")
          ->check(CLI::Range(1, 1000));
  file->excludes(random);
  app.add_option("--first-random", arguments.first_random, "Number of the first of them")
      ->check(CLI::Range(1, 1 << 30))
      ->needs(random);
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
               "Compare stills and blurred frames with the slow reference in double");
  app.add_option("--truth", arguments.truth, "Instants that others are compared with");
  CLI11_PARSE(app, argc, argv);
  if (arguments.file.empty() && arguments.random == 0) {
    fmt::print(stderr, "swept_splat_benchmark: FILE or --random N is needed\n");
    return 2;
  }
  if (const swept::Status status = swept::run(arguments); !status) {
    fmt::print(stderr, "swept_splat_benchmark: {}\n", status.error().message());
    return 1;
  }
  return 0;
}
