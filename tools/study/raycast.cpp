// Instants and shading; disc_volumes.h finds what a ray meets. A ray takes all hits that may be seen, not the
// nearest alone: discs within the depth tolerance of each other are one surface.
#include "tools/study/raycast.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include <tbb/blocked_range2d.h>
#include <tbb/enumerable_thread_specific.h>

#include "abuffer/parallel.h"
#include "abuffer/render_valid.h"
#include "abuffer/resolve/still.h"
#include "abuffer/sources/rasterize.h"
#include "splat/kernel/kernel_set.h"
#include "splat/lens_points.h"
#include "splat/stopwatch.h"
#include "tools/study/disc_volumes.h"

namespace swept {
namespace {

/// Side of the squares of pixels that threads share out.
constexpr int kTile = 16;

/// Numbers of [0, 1) of 24 bits for every pixel of the film. SplitMix64 (Steele, Lea and Flood 2014).
class Jitter {
 public:
  Jitter(std::uint64_t seed, int x, int y)
      : state_(mixed(mixed(seed) + (static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint32_t>(x)))) {}

  [[nodiscard]] double operator()(int i) const {
    return static_cast<double>(mixed(state_ + static_cast<std::uint64_t>(i)) >> 40) * 0x1p-24;
  }

 private:
  static std::uint64_t mixed(std::uint64_t v) {
    v = (v + 1) * 0x9e3779b97f4a7c15ULL;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ULL;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebULL;
    return v ^ (v >> 31);
  }

  std::uint64_t state_;
};

/// One thread's share of the film. Its memory is kept from ray to ray.
class Tracer {
 public:
  Tracer(const Scene& scene, const KernelSet& set, const std::vector<Shade>& shades,
         const DiscVolumes& volumes, const RaycastOptions& options, Image& image)
      : set_(set),
        projection_(set.projection),
        shades_(shades),
        backs_(static_cast<std::uint32_t>(shades.size() - set.kernels.size())),
        background_(scene.background.cast<double>()),
        volumes_(volumes),
        options_(options),
        image_(image),
        still_(SurfaceModel(scene.model)) {}

  void trace(int x, int y) {
    const double per_pixel = 1.0 / projection_.focal_px;
    DiscRay ray{(x + 0.5 - projection_.center_x) * per_pixel, (y + 0.5 - projection_.center_y) * per_pixel,
                0.0f};
    const Jitter jitter(options_.seed, x, y);
    const bool shared = options_.offsets == Offsets::shared;
    PixelSum pixel;
    for (int i = 0; i < options_.samples; ++i) {
      const double time = (i + jitter(shared ? 0 : i)) / options_.samples;
      ray.time = std::min(static_cast<float>(time), 1.0f - 0x1p-24f);
      hits += volumes_.meet(ray, met_);
      shade(ray, pixel);
    }
    store(x, y, pixel);
  }

  std::uint64_t hits = 0;

 private:
  /// By the rules, and the very code, of a still image.
  void shade(const DiscRay& ray, PixelSum& pixel) {
    const std::size_t count = met_.size();
    if (count == 0) return;
    fragments_.count = 0;
    fragments_.ensure(count);
    if (indices_.size() < count) indices_.resize(2 * count);
    for (std::size_t i = 0; i < count; ++i) {
      fragments_.kernel[i] = met_[i].kernel + (shows_back(met_[i].kernel, ray) ? backs_ : 0);
      fragments_.t_end[i] = 1.0f;
      fragments_.peak[i] = met_[i].rho;
      fragments_.z[i] = met_[i].z;
      indices_[i] = static_cast<std::uint32_t>(i);
    }
    fragments_.count = count;
    still_.resolve(fragments_, shades_, indices_.data(), count, pixel, ray.time);
  }

  [[nodiscard]] bool shows_back(std::uint32_t kernel, const DiscRay& ray) const {
    const Eigen::Vector3d outside = set_.kernels[kernel].outside.cast<double>();
    return backs_ != 0 && !outside.isZero(0.0) &&
           !(outside.x() * ray.x + outside.y() * ray.y + outside.z() < 0.0);
  }

  void store(int x, int y, const PixelSum& pixel) {
    const std::size_t i =
        static_cast<std::size_t>(y - image_.y) * static_cast<std::size_t>(image_.width) + (x - image_.x);
    const double per_sample = 1.0 / options_.samples, alpha = pixel.rgba[3] * per_sample;
    const double left = std::max(0.0, 1.0 - alpha);
    for (int c = 0; c < 4; ++c)
      image_.rgba[4 * i + c] = static_cast<float>(pixel.rgba[c] * per_sample + left * background_[c]);
    image_.depth[i] = alpha > 0.0 ? static_cast<float>(pixel.depth / pixel.rgba[3])
                                  : std::numeric_limits<float>::infinity();
  }

  const KernelSet& set_;
  Projection projection_;
  const std::vector<Shade>& shades_;
  std::uint32_t backs_;
  Eigen::Vector4d background_;
  const DiscVolumes& volumes_;
  const RaycastOptions& options_;
  Image& image_;
  StillPixel still_;
  std::vector<Hit> met_;
  FragmentArrays fragments_;
  std::vector<std::uint32_t> indices_;
};

Result<Rendered> render_checked(const Scene& scene, const RaycastOptions& given, const RenderControl&) {
  RaycastOptions options = given;
  Rendered out;
  Stopwatch watch;
  const KernelSet set = build_kernels(scene);
  const std::vector<Shade> shades = shades_of(set.kernels);
  if (set.still_kernels == set.kernels.size()) options.samples = 1;
  out.statistics.time("kernels", watch.lap());
  const Result<DiscVolumes> volumes = DiscVolumes::build(set, scene.model, options.threads);
  if (!volumes) return volumes.error();
  out.statistics.time("build", watch.lap());

  out.image = blank_image(scene.film);
  const Image& image = out.image;
  std::uint64_t hits = 0;
  tbb::enumerable_thread_specific<std::unique_ptr<Tracer>> tracers(
      [&] { return std::make_unique<Tracer>(scene, set, shades, *volumes, options, out.image); });
  const tbb::blocked_range2d<int> film(image.y, image.y + image.height, kTile, image.x, image.x + image.width,
                                       kTile);
  parallel_for_parts(film, [&](const auto& part) {
    Tracer& tracer = *tracers.local();
    for (int y = part.rows().begin(); y != part.rows().end(); ++y)
      for (int x = part.cols().begin(); x != part.cols().end(); ++x) tracer.trace(x, y);
  });
  for (const auto& tracer : tracers) hits += tracer->hits;
  out.statistics.time("trace", watch.lap());
  out.statistics.count("samples", options.samples);
  out.statistics.count("rays", static_cast<double>(image.pixel_count()) * options.samples);
  out.statistics.count("hits", static_cast<double>(hits));
  out.statistics.count("motion_ranges", static_cast<double>(volumes->motion_ranges()));
  return out;
}

}  // namespace

bool raycast_available() { return true; }

Result<Rendered> render_raycast(const Scene& scene, const RaycastOptions& options) {
  if (Status status = refuse_lens(scene, "the ray caster"); !status) return status.error();
  if (Status status = refuse_orthographic(scene, "the ray caster"); !status) return status.error();
  if (Status status = refuse_row_delay(scene, "the ray caster"); !status) return status.error();
  RenderControl control;
  control.threads = options.threads;
  return render_valid(scene, options, control, render_checked);
}

}  // namespace swept
