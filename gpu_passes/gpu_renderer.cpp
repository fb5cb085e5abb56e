#include "gpu_passes/gpu_renderer.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include "gpu_passes/device/context.h"
#include "gpu_passes/device/gl_errors.h"
#include "gpu_passes/six_pass/pass_runner.h"
#include "gpu_passes/six_pass/subframes.h"
#include "splat/lens_points.h"
#include "splat/stopwatch.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

FrameBlock frame_block(const Scene& scene, const PixelWindow& window, int subframes) {
  const auto number = [](auto value) { return static_cast<float>(value); };
  FrameBlock block;
  block.background = {scene.background[0], scene.background[1], scene.background[2], scene.background[3]};
  block.window_origin = {number(window.x), number(window.y)};
  block.window_size = {number(window.width), number(window.height)};
  block.near_plane = number(scene.camera.near);
  block.delta = number(scene.model.delta);
  block.edge_weight = scene.model.coverage == Coverage::hard ? 0.0f : number(scene.model.edge_weight);
  block.share = number(1.0 / subframes);
  return block;
}

/// `image` has its size. `weighted_depth`: Σ alpha z, Σ alpha.
void fill(Image& image, std::span<const float> color, std::span<const float> weighted_depth) {
  std::copy(color.begin(), color.end(), image.rgba.begin());
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    const float alpha = weighted_depth[2 * i + 1];
    image.depth[i] = alpha > 0.0f ? weighted_depth[2 * i] / alpha : std::numeric_limits<float>::infinity();
  }
}

/// Sums over sub-frames.
struct Counts {
  double kernels = 0, still = 0, degenerate = 0, near = 0, drawn = 0;
  std::size_t surfels = 0;

  void add(const KernelSet& set, std::size_t instances) {
    surfels = set.surfels;
    kernels += static_cast<double>(set.kernels.size());
    still += static_cast<double>(set.still_kernels);
    degenerate += static_cast<double>(set.culled_degenerate);
    near += static_cast<double>(set.culled_near);
    drawn += static_cast<double>(instances);
  }
  void report(Statistics& statistics) const {
    statistics.count("surfels", static_cast<double>(surfels));
    statistics.count("kernels", kernels);
    statistics.count("kernels_still", still);
    statistics.count("culled_degenerate", degenerate);
    statistics.count("culled_near", near);
    statistics.count("culled_outside", kernels - drawn);
    statistics.count("kernels_drawn", drawn);
  }
};

void describe(const Scene& scene, const GpuRenderOptions& options, const Subframes& subframes,
              Statistics& statistics) {
  const std::string n = std::to_string(subframes.count());
  if (subframes.still()) {
    statistics.effect("motion blur: skipped, nothing moves during the exposure");
  } else if (options.method == GpuMethod::still) {
    statistics.effect("motion blur: temporal supersampling, " + n + " still frames");
  } else {
    statistics.effect("motion blur: six passes for each of " + n + " sub-frames");
    statistics.effect("visibility: approximate, from the depths at both ends of each sub-frame");
  }
  if (options.clamp_motion && options.method == GpuMethod::six_pass)
    statistics.effect("motion: bent out of the discs' planes, as the paper's matrix needs it");
  if (scene.model.coverage == Coverage::soft)
    statistics.effect(
        "soft coverage: approximate, from mean kernel sums; what lies behind an edge is mixed into one "
        "surface");
  statistics.effect(options.lookup_tables ? "exp and erf: lookup tables" : "exp and erf: computed");
}

}  // namespace

Status GpuOptions::validate() const {
  if (batch_kernels < 1 || batch_kernels > (std::size_t{1} << 22))
    return Error{"", "batch_kernels", "must be in [1, 4194304]"};
  if (frames_in_flight < 1 || frames_in_flight > 16)
    return Error{"", "frames_in_flight", "must be in [1, 16]"};
  return Done{};
}

Status GpuRenderOptions::validate() const {
  if (subframes < 0 || subframes > 65536) return Error{"", "subframes", "must be in [0, 65536]"};
  return Done{};
}

Status check_gpu_scene(const Scene& scene) {
  return without_throwing("to check the scene", [&]() -> Status {
    if (Status status = refuse_splats(scene, "the GPU"); !status) return status;
    if (Status status = refuse_row_delay(scene, "the GPU"); !status) return status;
    if (Status status = refuse_lifetimes(scene, "the GPU"); !status) return status;
    if (Status status = refuse_triangles(scene, "the GPU"); !status) return status;
    if (Status status = refuse_lens(scene, "the GPU"); !status) return status;
    if (Status status = refuse_orthographic(scene, "the GPU"); !status) return status;
    if (scene.film.has_overscan())
      return Error{"", "/film/overscan", "is beyond the film, where the GPU does not draw",
                   ErrorKind::unsupported};
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      if (scene.objects[i].cloud.see_through())
        return Error{"", "/objects/" + std::to_string(i),
                     "has opacity below 1, and the GPU modes keep one surface per pixel; render it with the "
                     "A-buffer",
                     ErrorKind::unsupported};
    }
    return Done{};
  });
}

class GpuRenderer::Implementation {
 public:
  static Result<std::unique_ptr<Implementation>> create(const GpuOptions& options) {
    if (Status status = options.validate(); !status) return status.error();
    Result<GlContext> context = GlContext::create(options.device);
    if (!context) return context.error();
    std::unique_ptr<Implementation> made(new Implementation(std::move(*context), options.frames_in_flight));
    const CurrentContext current(made->context_);
    if (Status status = current.status(); !status) return status.error();
    keep_error_messages();
    Result<PassRunner> runner = PassRunner::create(options.batch_kernels);
    if (!runner) return runner.error();
    made->runner_.emplace(std::move(*runner));
    return made;
  }

  ~Implementation() {
    const CurrentContext current(context_);
    pending_.clear();
    spare_buffer_ = {};
    runner_.reset();
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  const GpuDevice& device() const { return context_.device(); }

  std::size_t pending() const { return pending_.size(); }
  std::size_t most_pending() const { return most_pending_; }

  Status submit(const Scene& scene, const GpuRenderOptions& options, const RenderControl& control) {
    if (pending_.size() == most_pending_)
      return Error{"", "frames_in_flight", std::to_string(most_pending_) + " are pending; collect one first"};
    const CurrentContext current(context_);
    if (Status status = current.status(); !status) return status;
    // What the device says by now about earlier frames is theirs.
    if (Status status = take_errors("the frame was drawn");
        !status && !pending_.empty() && !pending_.back().late_error)
      pending_.back().late_error = status.error();
    const PixelWindow window{scene.film.crop_x, scene.film.crop_y, scene.film.window_width(),
                             scene.film.window_height()};
    Stopwatch watch;
    double seconds_kernels = 0.0, seconds_issue = 0.0;
    Subframes subframes(scene, options);
    const FrameSetup setup{window.width, window.height,
                           options.method == GpuMethod::still ? still_passes() : six_passes(),
                           options.lookup_tables, frame_block(scene, window, subframes.count())};
    if (Status status = runner_->begin_frame(setup); !status) return status;
    Counts counts;
    const double seconds_begin = watch.lap();
    for (int j = 0; j < subframes.count(); ++j) {
      throw_if_stopped(control.stop);
      const KernelSet set = subframes.kernels(j);
      const std::vector<Instance> instances = make_instances(set, window);
      counts.add(set, instances.size());
      seconds_kernels += watch.lap();
      runner_->draw_subframe(instances);
      seconds_issue += watch.lap();
      if (control.progress) call_back(control.progress, (j + 1.0) / subframes.count());
    }
    throw_if_stopped(control.stop);
    Result<DrawnFrame> drawn = runner_->end_frame(std::exchange(spare_buffer_, {}));
    if (!drawn) return drawn.error();
    Statistics statistics;
    statistics.time("set up", seconds_begin);
    statistics.time("kernels", seconds_kernels);
    statistics.time("upload and issue", seconds_issue + watch.lap());
    counts.report(statistics);
    statistics.count("subframes", subframes.count());
    statistics.count("batches", static_cast<double>(drawn->batches));
    describe(scene, options, subframes, statistics);
    pending_.push_back({std::move(*drawn), scene.film, std::move(statistics), {}});
    return Done{};
  }

  Result<Rendered> collect() {
    if (pending_.empty()) return Error{"", "", "no frame was submitted"};
    const CurrentContext current(context_);
    if (Status status = current.status(); !status) return status.error();
    Pending frame = std::move(pending_.front());
    pending_.pop_front();
    Stopwatch watch;
    if (Status status = runner_->wait(frame.drawn); !status) return status.error();
    if (frame.late_error) return *frame.late_error;
    frame.statistics.time("wait for the GPU", watch.lap());
    Rendered out{blank_image(frame.film), std::move(frame.statistics)};
    const Status read = frame.drawn.pixels.read(
        [&](std::span<const float> color, std::span<const float> depth) { fill(out.image, color, depth); });
    if (!read) return read.error();
    spare_buffer_ = frame.drawn.pixels.take_buffer();
    out.statistics.time("read back", watch.lap());
    for (std::size_t i = 0; i < frame.drawn.seconds->size(); ++i)
      out.statistics.time(std::string(frame.drawn.passes[i].name) + ", GPU", (*frame.drawn.seconds)[i]);
    return out;
  }

 private:
  struct Pending {
    DrawnFrame drawn;
    Film film;
    Statistics statistics;
    std::optional<Error> late_error;
  };

  Implementation(GlContext context, std::size_t most_pending)
      : context_(std::move(context)), most_pending_(most_pending) {}

  GlContext context_;
  std::optional<PassRunner> runner_;
  std::deque<Pending> pending_;
  PixelBuffer spare_buffer_;
  std::size_t most_pending_;
};

Result<GpuRenderer> GpuRenderer::create(const GpuOptions& options) {
  return without_throwing("for the GPU", [&]() -> Result<GpuRenderer> {
    Result<std::unique_ptr<Implementation>> made = Implementation::create(options);
    if (!made) return made.error();
    return GpuRenderer(std::move(*made));
  });
}

GpuRenderer::GpuRenderer(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
GpuRenderer::GpuRenderer(GpuRenderer&&) noexcept = default;
GpuRenderer& GpuRenderer::operator=(GpuRenderer&&) noexcept = default;
GpuRenderer::~GpuRenderer() = default;

const GpuDevice& GpuRenderer::device() const { return implementation_->device(); }

std::size_t GpuRenderer::pending() const { return implementation_->pending(); }
std::size_t GpuRenderer::most_pending() const { return implementation_->most_pending(); }

Status GpuRenderer::submit(const Scene& scene, const GpuRenderOptions& options,
                           const RenderControl& control) {
  return without_throwing("to render the frame", [&]() -> Status {
    if (Status status = options.validate(); !status) return status;
    if (Status status = scene.validate(); !status) return status;
    if (Status status = check_gpu_scene(scene); !status) return status;
    if (Status status = control.validate(); !status) return status;
    return implementation_->submit(scene, options, control);
  });
}

Result<Rendered> GpuRenderer::collect() {
  return without_throwing("to read the frame back",
                          [&]() -> Result<Rendered> { return implementation_->collect(); });
}

Result<Rendered> GpuRenderer::render(const Scene& scene, const GpuRenderOptions& options,
                                     const RenderControl& control) {
  if (pending() > 0)
    return Error{"", "frames_in_flight", std::to_string(pending()) + " are pending; collect them first"};
  if (Status status = submit(scene, options, control); !status) return status.error();
  return collect();
}

}  // namespace swept
