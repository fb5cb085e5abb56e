#include "abuffer/reference/reference.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <new>
#include <string>

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "abuffer/reference/reference_frame.h"
#include "abuffer/reference/splat_reference.h"

#include "splat/motion/segments.h"
#include "splat/stopwatch.h"

namespace swept {
namespace {

/// The kernels that exist at a shutter time. The set lives until the next call.
using KernelsAt = std::function<const KernelSet&(double tau)>;

/// Adds the still images at the midpoints of `samples` strata of the shutter.
void expose(const KernelsAt& kernels_at, int samples, reference::FrameSum& sum) {
  for (int i = 0; i < samples; ++i) {
    const double tau = (i + 0.5) / samples;
    sum.add(kernels_at(tau), tau);
  }
}

bool nothing_moves(const KernelSet& set) {
  return std::all_of(set.kernels.begin(), set.kernels.end(), [](const MovingKernel& kernel) {
    return kernel.still() && kernel.t_begin <= 0.0f && kernel.t_end >= 1.0f;
  });
}

double rmse_of_rgb(const Image& a, const Image& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double difference = static_cast<double>(a.rgba[i]) - static_cast<double>(b.rgba[i]);
    squares += difference * difference;
  }
  return std::sqrt(squares / (3.0 * static_cast<double>(a.pixel_count())));
}

void add_kernel_counts(const KernelSet& set, Statistics& statistics) {
  statistics.count("surfels", static_cast<double>(set.surfels));
  statistics.count("kernels", static_cast<double>(set.kernels.size()));
  statistics.count("still_kernels", static_cast<double>(set.still_kernels));
  statistics.count("culled_degenerate", static_cast<double>(set.culled_degenerate));
  statistics.count("culled_near", static_cast<double>(set.culled_near));
}

struct Source {
  KernelsAt kernels_at;
  bool still = false;
  const char* motion = "";
};

Rendered render(const Source& source, const Scene& scene, const ReferenceOptions& options) {
  Rendered rendered;
  Statistics& statistics = rendered.statistics;
  const int samples = source.still ? 1 : options.samples;

  Stopwatch watch;
  reference::FrameSum sum(scene.film, scene.model, scene.background);
  expose(source.kernels_at, samples, sum);
  rendered.image = sum.mean();
  statistics.time("still images", watch.lap());

  std::uint64_t instants = sum.instants(), fragments = sum.fragments(), surfaces = sum.surfaces();
  double error = 0.0;
  if (!source.still) {
    reference::FrameSum half(scene.film, scene.model, scene.background);
    expose(source.kernels_at, samples / 2, half);
    error = rmse_of_rgb(rendered.image, half.mean()) / std::sqrt(6.0);
    instants += half.instants(), fragments += half.fragments(), surfaces += half.surfaces();
    statistics.time("error estimate", watch.lap());
  }

  statistics.count("samples", samples);
  statistics.count("instants", static_cast<double>(instants));
  statistics.count("fragments", static_cast<double>(fragments));
  statistics.count("surfaces", static_cast<double>(surfaces));
  statistics.count("reference_error_rmse", error);
  statistics.count("reference_error_psnr_db", -20.0 * std::log10(error));
  statistics.effect(source.still
                        ? "motion blur: skipped, for the shutter is closed or nothing moves"
                        : "motion blur: " + std::to_string(samples) + " still images of " + source.motion);
  return rendered;
}

Rendered render_segments(const KernelSet& kernels, const Scene& scene, const ReferenceOptions& options) {
  const auto same_for_all = [&](double) -> const KernelSet& { return kernels; };
  Rendered rendered = render({same_for_all, nothing_moves(kernels), "linear segments"}, scene, options);
  add_kernel_counts(kernels, rendered.statistics);
  return rendered;
}

Rendered render_smooth(const Scene& scene, const ReferenceOptions& options) {
  const Exposure exposure = scene.exposure();
  KernelSet kernels;
  double seconds = 0.0;
  const auto rebuild = [&](double tau) -> const KernelSet& {
    Stopwatch watch;
    const double frame = exposure.at(tau);
    kernels = build_kernels(scene, {frame, frame});
    seconds += watch.lap();
    return kernels;
  };
  Rendered rendered = render({rebuild, nothing_moves(scene, exposure), "the true path"}, scene, options);
  add_kernel_counts(kernels, rendered.statistics);
  rendered.statistics.time("kernels", seconds);
  return rendered;
}

Status validate(const Scene& scene, const ReferenceOptions& options) {
  if (Status status = options.validate(); !status) return status;
  return scene.validate();
}

/// Runs `work` on `threads` threads; what runs out is memory, and nothing else is thrown.
template <class Work>
Result<Rendered> run_in_arena(int threads, const Work& work) {
  try {
    // An arena larger than the machine gains nothing, and makes oneTBB print a warning.
    const int available = tbb::info::default_concurrency();
    tbb::task_arena arena(threads > 0 ? std::min(threads, available) : available);
    return arena.execute(work);
  } catch (const std::bad_alloc&) {
    return Error{"", "", "not enough memory to render the reference"};
  }
}

}  // namespace

Status ReferenceOptions::validate() const {
  if (samples < 2 || samples > (1 << 20) || samples % 2 != 0) {
    return Error{"", "samples", "must be even and from 2 to 1048576, not " + std::to_string(samples)};
  }
  if (threads < 0 || threads > 1024) {
    return Error{"", "threads", "must be from 0 to 1024, not " + std::to_string(threads)};
  }
  return Done{};
}

Result<Rendered> render_reference(const KernelSet& kernels, const Scene& scene,
                                  const ReferenceOptions& options) {
  if (Status status = validate(scene, options); !status) return status.error();
  return run_in_arena(options.threads, [&] { return render_segments(kernels, scene, options); });
}

Result<Rendered> render_reference(const Scene& scene, const ReferenceOptions& options) {
  if (Status status = validate(scene, options); !status) return status.error();
  if (!refuse_splats(scene, "this")) return render_splat_reference(scene, {options.samples, options.threads});
  return run_in_arena(options.threads, [&] {
    if (options.motion == ReferenceMotion::smooth) return render_smooth(scene, options);
    Stopwatch watch;
    const KernelSet kernels = build_kernels(scene);
    const double seconds = watch.lap();
    Rendered rendered = render_segments(kernels, scene, options);
    rendered.statistics.time("kernels", seconds);
    return rendered;
  });
}

}  // namespace swept
