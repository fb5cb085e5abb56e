#include "gpu_passes/gpu_renderer.h"

#include <limits>
#include <new>
#include <utility>

#include "gpu_passes/context.h"
#include "gpu_passes/pass_runner.h"
#include "gpu_passes/subframes.h"
#include "splat/stopwatch.h"

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

Image image_of(const Film& film, std::vector<float> color, const std::vector<float>& depth) {
  Image image = blank_image(film);
  image.rgba = std::move(color);
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    const float alpha = depth[2 * i + 1];
    image.depth[i] = alpha > 0.0f ? depth[2 * i] / alpha : std::numeric_limits<float>::infinity();
  }
  return image;
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
  return Done{};
}

Status GpuRenderOptions::validate() const {
  if (subframes < 0 || subframes > 65536) return Error{"", "subframes", "must be in [0, 65536]"};
  return Done{};
}

Status check_gpu_scene(const Scene& scene) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const std::vector<float>& opacity = scene.objects[i].cloud.opacity;
    for (const float value : opacity)
      if (value < 1.0f)
        return Error{"", "/objects/" + std::to_string(i),
                     "has opacity below 1, and the GPU modes keep one surface per pixel; render it with the "
                     "A-buffer"};
  }
  return Done{};
}

class GpuRenderer::Implementation {
 public:
  static Result<std::unique_ptr<Implementation>> create(const GpuOptions& options) {
    if (Status status = options.validate(); !status) return status.error();
    Result<GlContext> context = GlContext::create(options.device);
    if (!context) return context.error();
    std::unique_ptr<Implementation> made(new Implementation(std::move(*context)));
    const CurrentContext current(made->context_);
    if (Status status = current.status(); !status) return status.error();
    Result<PassRunner> runner = PassRunner::create(options.batch_kernels);
    if (!runner) return runner.error();
    made->runner_.emplace(std::move(*runner));
    return made;
  }

  ~Implementation() {
    const CurrentContext current(context_);
    runner_.reset();
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  const GpuDevice& device() const { return context_.device(); }

  Result<Rendered> render(const Scene& scene, const GpuRenderOptions& options) {
    const CurrentContext current(context_);
    if (Status status = current.status(); !status) return status.error();
    const PixelWindow window{scene.film.crop_x, scene.film.crop_y, scene.film.window_width(),
                             scene.film.window_height()};
    Stopwatch watch;
    double seconds_kernels = 0.0, seconds_issue = 0.0;
    Status begun = runner_->begin_frame(window.width, window.height,
                                        options.method == GpuMethod::still ? still_passes() : six_passes(),
                                        options.lookup_tables);
    if (!begun) return begun.error();
    Subframes subframes(scene, options);
    const FrameBlock block = frame_block(scene, window, subframes.count());
    Counts counts;
    const double seconds_begin = watch.lap();
    for (int j = 0; j < subframes.count(); ++j) {
      const KernelSet set = subframes.kernels(j);
      const std::vector<Instance> instances = make_instances(set, window);
      counts.add(set, instances.size());
      seconds_kernels += watch.lap();
      runner_->draw_subframe(instances, block);
      seconds_issue += watch.lap();
    }
    if (Status status = runner_->end_frame(); !status) return status.error();
    const double seconds_wait = watch.lap();
    Rendered out;
    out.image = image_of(scene.film, runner_->read(Target::frame_color), runner_->read(Target::frame_depth));

    Statistics& statistics = out.statistics;
    statistics.time("set up", seconds_begin);
    statistics.time("kernels", seconds_kernels);
    statistics.time("upload and issue", seconds_issue);
    statistics.time("wait for the GPU", seconds_wait);
    statistics.time("read back", watch.lap());
    for (const auto& [pass, seconds] : runner_->pass_seconds()) statistics.time(pass + ", GPU", seconds);
    statistics.count("subframes", subframes.count());
    statistics.count("surfels", static_cast<double>(counts.surfels));
    statistics.count("kernels", counts.kernels);
    statistics.count("kernels_still", counts.still);
    statistics.count("culled_degenerate", counts.degenerate);
    statistics.count("culled_near", counts.near);
    statistics.count("culled_outside", counts.kernels - counts.drawn);
    statistics.count("kernels_drawn", counts.drawn);
    statistics.count("batches", static_cast<double>(runner_->batches()));
    describe(scene, options, subframes, statistics);
    return out;
  }

 private:
  explicit Implementation(GlContext context) : context_(std::move(context)) {}

  GlContext context_;
  std::optional<PassRunner> runner_;
};

Result<GpuRenderer> GpuRenderer::create(const GpuOptions& options) {
  Result<std::unique_ptr<Implementation>> made = Implementation::create(options);
  if (!made) return made.error();
  return GpuRenderer(std::move(*made));
}

GpuRenderer::GpuRenderer(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
GpuRenderer::GpuRenderer(GpuRenderer&&) noexcept = default;
GpuRenderer& GpuRenderer::operator=(GpuRenderer&&) noexcept = default;
GpuRenderer::~GpuRenderer() = default;

const GpuDevice& GpuRenderer::device() const { return implementation_->device(); }

Result<Rendered> GpuRenderer::render(const Scene& scene, const GpuRenderOptions& options) {
  if (Status status = options.validate(); !status) return status.error();
  if (Status status = scene.validate(); !status) return status.error();
  if (Status status = check_gpu_scene(scene); !status) return status.error();
  try {
    return implementation_->render(scene, options);
  } catch (const std::bad_alloc&) {
    return Error{"", "", "not enough memory to render the frame"};
  }
}

}  // namespace swept
