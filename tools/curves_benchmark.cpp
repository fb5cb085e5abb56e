// What curved paths cost: of many points that move straight a few are bent, spin or change what they look
// like, and the picture is compared with the same scene without that.
//
// Usage: swept_curves_benchmark [--points N] [--share S] [--repeats N] [--methods engine,exact] [--cases
// NAME,…] Prints, as Markdown, CPU seconds of a render, all threads together, and peak memory beyond the
// scene's own, each the median of its runs, and ratios to the scene without what the case adds, which is run
// in turn with it: the straight one, or of what stands still the one whose shutter is closed. Every run is a
// process of its own.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
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
#include "tools/cpu_seconds.h"
#include "tools/engine_scenes.h"

namespace swept {
namespace {

constexpr double way_px = 30.0;

struct Case {
  const char* name;
  const char* against;  ///< of which ratios are said
  const char* help;
};
constexpr Case cases[] = {
    {"straight", "straight", "every point moves by 30 px"},
    {"zeros", "straight", "with accelerations and spins that are all zero"},
    {"curved", "straight", "a share goes there by arcs of 100 px to the side: 32 segments"},
    {"opacity-1", "straight", "with an opacity of 1 for every point"},
    {"lens-0", "straight", "through a lens of radius 0"},
    {"still", "closed", "nothing moves"},
    {"closed", "closed", "nothing moves, and the shutter is open for no time"},
    {"zero-velocities", "closed", "with velocities that are all zero"},
    {"small-moves", "still", "nothing moves but a sphere of a hundredth of the points in front"},
    {"large-moves", "still", "the same with a sphere of twice the radius and four times the points"},
    {"as-far", "straight", "that share moves straight, as far as the arcs are long"},
    {"spinning", "straight", "a share turns by one radian about itself"},
    {"mortal", "straight", "a share begins or ends half-way"},
    {"all-curved", "straight", "every point goes by an arc of 15 px to the side: 13 segments"},
    {"all-far-curved", "straight", "every point goes by an arc of 100 px to the side"},
};

Result<Scene> make(const std::string& name, std::size_t points, double share) {
  Scene scene = engine_stage();
  Object object;
  Result<SurfelCloud> cloud = generate("sphere", points, {{"sectors", 24}, {"rings", 12}});
  if (!cloud) return cloud.error();
  object.cloud = *std::move(cloud);
  const Eigen::Vector3f way(static_cast<float>(way_px / engine_px_per_unit), 0.0f, 0.0f);
  const bool one_moves = name.ends_with("-moves");
  const bool still = one_moves || name == "still" || name == "closed" || name == "zero-velocities";
  if (!still) object.cloud.velocity.assign(object.cloud.size(), way);
  const bool all = name.starts_with("all");
  const auto every = all ? std::size_t{1} : static_cast<std::size_t>(std::max(1.0, std::round(1.0 / share)));
  // ½ b t (1 − t) to the side, most of it half-way: b/8.
  const double side_px = name == "all-curved" ? 15.0 : 100.0;
  const Eigen::Vector3f bend(0.0f, static_cast<float>(8.0 * side_px / engine_px_per_unit), 0.0f);
  const auto of_share = [&](const auto& change) {
    for (std::size_t i = 0; i < object.cloud.size(); i += every) change(i);
  };
  const auto zeros = [&](auto& rates) { rates.assign(object.cloud.size(), Eigen::Vector3f::Zero()); };
  if (name == "opacity-1") object.cloud.opacity.assign(object.cloud.size(), 1.0f);
  if (name == "zero-velocities") zeros(object.cloud.velocity);
  if (name == "closed") scene.shutter.close = scene.shutter.open;
  if (name == "lens-0") scene.camera.aperture.blades = 6;
  if (name == "zeros") {
    zeros(object.cloud.acceleration);
    zeros(object.cloud.angular_velocity);
  } else if (name.ends_with("curved")) {
    zeros(object.cloud.acceleration);
    of_share([&](std::size_t i) {
      object.cloud.acceleration[i] = -bend;
      object.cloud.velocity[i] += 0.5f * bend;
    });
  } else if (name == "as-far") {
    of_share([&](std::size_t i) { object.cloud.velocity[i] *= static_cast<float>(2.0 * side_px / way_px); });
  } else if (name == "spinning") {
    zeros(object.cloud.angular_velocity);
    of_share([&](std::size_t i) { object.cloud.angular_velocity[i] = {0.6f, 0.8f, 0.0f}; });
  } else if (name == "mortal") {
    object.cloud.lifetime.assign(object.cloud.size(), {-1e300, 1e300});
    of_share([&](std::size_t i) {
      (i & 1 ? object.cloud.lifetime[i].born : object.cloud.lifetime[i].gone) = 0.5;
    });
  }
  scene.objects.push_back(std::move(object));
  if (one_moves) {
    const double radius = name == "small-moves" ? 0.1 : 0.2;
    Object mover;
    Result<SurfelCloud> small = generate(
        "sphere", static_cast<std::size_t>(std::max(10.0, radius * radius * static_cast<double>(points))),
        {{"sectors", 24}, {"rings", 12}, {"radius", radius}});
    if (!small) return small.error();
    mover.cloud = *std::move(small);
    mover.cloud.velocity.assign(mover.cloud.size(), way);
    mover.transform.keys.resize(1);
    mover.transform.keys[0].translate = {0.0, 0.0, 1.5};
    scene.objects.push_back(std::move(mover));
  }
  return scene;
}

struct Cost {
  double seconds = 0.0, mebibytes = 0.0, instants = 0.0, kernels = 0.0, swept = 0.0, psnr_db = 0.0;
};

double peak_mebibytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// In a process of its own, whose peak is nobody else's.
std::optional<Cost> cost_of(const std::string& name, const std::string& method, std::size_t points,
                            double share, const RenderControl& control, int reference) {
  int ends[2];
  if (pipe(ends) != 0) return std::nullopt;
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    const Result<Scene> scene = make(name, points, share);
    if (!scene) {
      fmt::print(stderr, "{}\n", scene.error().message());
      _exit(1);
    }
    const double memory = peak_mebibytes(), start = cpu_seconds();
    const Result<Rendered> rendered =
        method == "exact" ? render_abuffer(*scene, {}, control) : render_sampled(*scene, {}, control);
    Cost cost{cpu_seconds() - start, peak_mebibytes() - memory};
    if (!rendered) {
      fmt::print(stderr, "{}\n", rendered.error().message());
      _exit(1);
    }
    cost.instants = rendered->statistics.counter("instants_per_pixel").value_or(0.0);
    cost.kernels = rendered->statistics.counter("kernels").value_or(0.0);
    cost.swept = rendered->statistics.counter("pixels_swept").value_or(0.0);
    if (reference > 0) {
      SampledOptions many;
      many.samples = reference;
      const Result<Rendered> truth = render_sampled(*scene, many, control);
      if (truth)
        if (const auto metrics = compare_images(rendered->image, truth->image))
          cost.psnr_db = metrics->psnr_db;
    }
    _exit(write(ends[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
  }
  close(ends[1]);
  Cost cost;
  const bool read_all = child > 0 && read(ends[0], &cost, sizeof cost) == sizeof cost;
  close(ends[0]);
  int status = 0;
  if (child > 0) waitpid(child, &status, 0);
  if (!read_all || status != 0) return std::nullopt;
  return cost;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

int run(int argc, char** argv) {
  CLI::App app("What curved paths cost");
  std::size_t points = 100'000;
  double share = 0.01;
  int repeats = 3;
  RenderControl control;
  control.threads = 1;
  std::vector<std::string> methods{"engine", "exact"}, names;
  for (const Case& entry : cases) names.emplace_back(entry.name);
  app.add_option("--points", points)->check(CLI::Range(100, 100'000'000));
  app.add_option("--share", share, "Of the points that curve")->check(CLI::Range(1e-6, 1.0));
  app.add_option("--repeats", repeats)->check(CLI::Range(1, 1000));
  app.add_option("--threads", control.threads);
  int reference = 0;
  app.add_option("--reference", reference, "Instants of a picture that others are compared with; 0: none");
  app.add_option("--methods", methods)->delimiter(',')->check(CLI::IsMember({"engine", "exact"}));
  app.add_option("--cases", names)->delimiter(',');
  CLI11_PARSE(app, argc, argv);
  fmt::print("{} points, of which {} % differ\n\n", points, 100.0 * share);
  fmt::print(
      "| case | method | CPU s | ratio | memory, MiB | ratio | instants a pixel | kernels | "
      "pixels swept | PSNR, dB |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& method : methods)
    for (const std::string& name : names) {
      const auto* of = std::find_if(std::begin(cases), std::end(cases),
                                    [&](const Case& entry) { return entry.name == name; });
      if (of == std::end(cases)) return fmt::print(stderr, "There is no case {}\n", name), 2;
      const char* const against = of->against;
      std::vector<double> seconds, memory, time_ratios, memory_ratios;
      Cost last;
      for (int k = 0; k < repeats; ++k) {
        const auto base = cost_of(against, method, points, share, control, 0);
        const auto cost = cost_of(name, method, points, share, control, k == 0 ? reference : 0);
        if (!base || !cost) return fmt::print(stderr, "{} by {} failed\n", name, method), 1;
        const double psnr_db = k == 0 ? cost->psnr_db : last.psnr_db;
        last = *cost;
        last.psnr_db = psnr_db;
        seconds.push_back(cost->seconds);
        memory.push_back(cost->mebibytes);
        time_ratios.push_back(cost->seconds / base->seconds);
        memory_ratios.push_back(cost->mebibytes / base->mebibytes);
      }
      fmt::print("| {} | {} | {:.2f} | {:.3f} | {:.0f} | {:.2f} | {:.1f} | {:.0f} | {:.0f} | {} |\n", name,
                 method, median(seconds), median(time_ratios), median(memory), median(memory_ratios),
                 last.instants, last.kernels, last.swept,
                 last.psnr_db > 0.0 ? fmt::format("{:.1f}", last.psnr_db) : "-");
      std::fflush(stdout);
    }
  fmt::print("\n");
  for (const Case& entry : cases) fmt::print("- {}: {}\n", entry.name, entry.help);
  return 0;
}

}  // namespace
}  // namespace swept

int main(int argc, char** argv) { return swept::run(argc, argv); }
