#include "tools/engine_points.h"

#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include <fmt/core.h>

#include "abuffer/sampled.h"
#include "tools/cpu_seconds.h"
#include "tools/engine_scenes.h"

namespace swept {
namespace {

struct Run {
  double seconds = 0.0, instants = 0.0;
};

/// The quicker of two, of which the first warms up.
std::optional<Run> run(const Scene& scene, const SampledOptions& options, const RenderControl& control) {
  std::optional<Run> best;
  for (int k = 0; k < 2; ++k) {
    const double start = cpu_seconds();
    const Result<Rendered> rendered = render_sampled(scene, options, control);
    const double seconds = cpu_seconds() - start;
    if (!rendered) {
      fmt::print(stderr, "{}\n", rendered.error().message());
      return std::nullopt;
    }
    if (!best || seconds < best->seconds)
      best = {seconds, rendered->statistics.counter("instants_per_pixel").value_or(0.0)};
  }
  return best;
}

}  // namespace

int print_times_by_points(std::size_t most, const RenderControl& control) {
  constexpr std::pair<std::size_t, const char*> spheres[] = {{10'000, "sphere-10k-30"},
                                                             {100'000, "sphere-100k-30"},
                                                             {1'000'000, "sphere-1M-30"},
                                                             {10'000'000, "sphere-10M-30"}};
  fmt::print(
      "| points | still: s, µs a point | 16 instants: s, µs a point | 60 dB: s, µs a point, instants a "
      "pixel, "
      "stills |\n|---|---|---|---|\n");
  for (const auto& [points, name] : spheres) {
    if (points > most) continue;
    const Result<EngineScene> moving = make_engine_scene(name);
    if (!moving) return fmt::print(stderr, "{}\n", moving.error().message()), 1;
    Scene closed = moving->scene;
    closed.shutter.open = closed.shutter.close = 0.5 * (closed.shutter.open + closed.shutter.close);
    SampledOptions one, sixteen;
    one.samples = 1;
    sixteen.samples = 16;
    const std::optional<Run> still = run(closed, one, control),
                             instants = run(moving->scene, sixteen, control),
                             asked = run(moving->scene, {}, control);
    if (!still || !instants || !asked) return 1;
    const auto each = [count = static_cast<double>(points)](const Run& of) {
      return fmt::format("{:.3f}, {:.3f}", of.seconds, 1e6 * of.seconds / count);
    };
    fmt::print("| {} | {} | {} | {}, {:.1f}, {:.1f} |\n", points, each(*still), each(*instants), each(*asked),
               asked->instants, asked->seconds / still->seconds);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace swept
