#include "abuffer/abuffer.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>

#include <tbb/blocked_range.h>

#include "abuffer/deep_store.h"
#include "abuffer/exact_meshes.h"
#include "abuffer/parallel.h"
#include "abuffer/progress_of.h"
#include "abuffer/render_valid.h"
#include "abuffer/resolve/still.h"
#include "abuffer/resolve/sweep.h"
#include "abuffer/sampled.h"
#include "abuffer/sweep_counts.h"
#include "abuffer/through_lens.h"
#include "abuffer/tiles/bins.h"
#include "splat/kernel/kernel_set.h"
#include "splat/motion/segments.h"
#include "splat/stopwatch.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

/// One thread's tile: fragments of a window, then pixel by pixel. Its memory is kept from tile to tile.
class TileRenderer {
 public:
  TileRenderer(const Scene& scene, const KernelSet& set, const std::vector<Shade>& shades,
               const std::vector<ShadeChange>& changes, const AbufferOptions& options, std::stop_token stop,
               const Image* standing, Image& image, DeepStore* deep)
      : set_(set),
        shades_(shades),
        changes_(changes),
        background_(scene.background.cast<double>()),
        raster_{set.projection, set.near, scene.model.delta,
                static_cast<std::uint32_t>(shades.size() - set.kernels.size()),
                scene.shutter.row_delay == 0.0
                    ? 0.0
                    : scene.shutter.row_delay / (scene.shutter.close - scene.shutter.open)},
        fragment_limit_(options.tile_fragments),
        stop_(std::move(stop)),
        standing_(standing),
        image_(image),
        deep_(deep),
        per_pixel_(options.normalisation == Normalisation::pixel),
        still_(SurfaceModel(scene.model, options.normalisation)),
        still_by_interval_(SurfaceModel(scene.model)),
        sweep_(SurfaceModel(scene.model, options.normalisation),
               options.simd ? interval_math_builds().back() : interval_math_builds().front()) {}

  void render(const Window& window, std::span<const std::uint32_t> kernels) {
    octagons_.clear();
    for (const std::uint32_t k : kernels) {
      Octagon octagon;
      if (screen_bounds(set_.kernels[k], set_.projection, set_.near, octagon))
        octagons_.push_back({k, octagon});
    }
    render_part(window, true);
  }

  SweepCounts counters;

 private:
  struct BoundedKernel {
    std::uint32_t index;
    Octagon octagon;
  };

  /// Halves the window until its fragments fit; a single pixel always does.
  void render_part(const Window& window, bool whole) {
    if (stop_.stop_requested()) return;
    std::size_t bound = 0;
    for (const BoundedKernel& kernel : octagons_) bound += visited_pixels(kernel.octagon, window);
    if (bound > fragment_limit_ && window.width * window.height > 1) {
      if (whole) ++counters.split_tiles;
      const auto [first, second] = window.halves();
      render_part(first, false);
      render_part(second, false);
      return;
    }
    Stopwatch watch;
    fragments_.count = 0;
    for (const BoundedKernel& kernel : octagons_)
      rasterize(set_.kernels[kernel.index], kernel.index, kernel.octagon, raster_, window, fragments_);
    sort_by_pixel(window);
    counters.seconds_rasterize += watch.lap();
    resolve(window);
    counters.seconds_resolve += watch.lap();
  }

  /// A stable counting sort of fragment indices: within a pixel they keep the order of the kernels.
  void sort_by_pixel(const Window& window) {
    const std::size_t pixels =
        static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
    starts_.assign(pixels + 1, 0);
    moving_.assign(pixels, 0);
    for (std::size_t i = 0; i < fragments_.count; ++i) {
      ++starts_[fragments_.pixel[i] + 1];
      if (!is_still(fragments_, i)) moving_[fragments_.pixel[i]] = 1;
    }
    changing_.assign(changes_.empty() ? 0 : pixels, 0);
    for (std::size_t i = 0; i < fragments_.count && !changes_.empty(); ++i)
      if (changes_[fragments_.kernel[i]].any())
        moving_[fragments_.pixel[i]] = changing_[fragments_.pixel[i]] = 1;
    for (std::size_t p = 0; p < pixels; ++p) starts_[p + 1] += starts_[p];
    sorted_.resize(fragments_.count);
    fill_.assign(starts_.begin(), starts_.end() - 1);
    for (std::size_t i = 0; i < fragments_.count; ++i)
      sorted_[fill_[fragments_.pixel[i]]++] = static_cast<std::uint32_t>(i);
  }

  void resolve(const Window& window) {
    counters.fragments += fragments_.count;
    std::size_t local = 0;
    for (int y = window.y; y < window.y + window.height; ++y)
      for (int x = window.x; x < window.x + window.width; ++x, ++local) {
        if (stop_.stop_requested()) return;
        std::uint32_t* indices = sorted_.data() + starts_[local];
        const std::size_t count = starts_[local + 1] - starts_[local];
        PixelSum pixel;
        if (deep_ != nullptr) pixel.by_depth = &deep_->pixel(index_of(x, y));
        if (count > 0) {
          counters.most_fragments = std::max<std::uint64_t>(counters.most_fragments, count);
          if (moving_[local]) {
            ++counters.swept_pixels;
            ChangingShades changing;
            if (!changing_.empty() && changing_[local]) changing = {changes_.data(), raster_.row_delay * y};
            sweep_.resolve(fragments_, shades_, indices, count, pixel, counters.sweep, changing);
          } else {
            ++counters.still_pixels;
            if (standing_ == nullptr || per_pixel_ || deep_ != nullptr)
              still_.resolve(fragments_, shades_, indices, count, pixel);
            if (standing_ != nullptr) {
              store_standing(x, y, pixel, indices, count);
              continue;
            }
          }
        }
        store(x, y, pixel);
      }
  }

  [[nodiscard]] std::size_t index_of(int x, int y) const {
    return static_cast<std::size_t>(y - image_.y) * static_cast<std::size_t>(image_.width) +
           static_cast<std::size_t>(x - image_.x);
  }

  /// Alpha and depth do not depend on the normalisation, nor does the colour of a single surface.
  void store_standing(int x, int y, const PixelSum& pixel, std::uint32_t* indices, std::size_t count) {
    const std::size_t i = index_of(x, y);
    store(x, y, pixel);
    image_.depth[i] = standing_->depth[i];
    image_.rgba[4 * i + 3] = standing_->rgba[4 * i + 3];
    if (per_pixel_) {
      PixelSum by_interval;
      still_by_interval_.resolve(fragments_, shades_, indices, count, by_interval);
      for (int c = 0; c < 3; ++c)
        if (by_interval.rgba[c] != pixel.rgba[c]) return;
    }
    for (std::size_t c = 0; c < 3; ++c) image_.rgba[4 * i + c] = standing_->rgba[4 * i + c];
  }

  void store(int x, int y, const PixelSum& pixel) {
    const std::size_t i = index_of(x, y);
    const double left = std::max(0.0, 1.0 - pixel.rgba[3]);
    for (int c = 0; c < 4; ++c)
      image_.rgba[4 * i + c] = static_cast<float>(pixel.rgba[c] + left * background_[c]);
    image_.depth[i] = pixel.rgba[3] > 0.0 ? static_cast<float>(pixel.depth / pixel.rgba[3])
                                          : std::numeric_limits<float>::infinity();
  }

  const KernelSet& set_;
  const std::vector<Shade>& shades_;
  const std::vector<ShadeChange>& changes_;  ///< empty: no colour changes
  Eigen::Vector4d background_;
  RasterModel raster_;
  std::size_t fragment_limit_;
  std::stop_token stop_;
  const Image* standing_;  ///< what does not move, where that is known; else null
  Image& image_;
  DeepStore* deep_;  ///< null: nobody asked for it
  bool per_pixel_;
  StillPixel still_, still_by_interval_;
  PixelSweep sweep_;
  std::vector<BoundedKernel> octagons_;
  FragmentArrays fragments_;
  std::vector<std::uint32_t> starts_, fill_, sorted_;
  std::vector<std::uint8_t> moving_, changing_;  ///< by pixel
};

/// What stands still, by the engine that makes still images: whatever they are part of, they have the same
/// bits.
Result<Rendered> render_standing(const Scene& scene, const AbufferOptions& options,
                                 const RenderControl& control) {
  SampledOptions instant;
  instant.samples = 1;
  // Rows at instants of their own stand still each by itself.
  instant.only_standing = !scene.exposure().instant();
  if (!options.simd) instant.implementation = 0;
  return render_sampled(scene, instant, control);
}

/// What the sweep cannot do with rows that are exposed one after the other.
Status check_rows(const Scene& scene) {
  if (scene.shutter.row_delay == 0.0) return Done{};
  if (scene.shutter.curve != ShutterShape::box)
    return Error{
        "", "/shutter/curve",
        "with a row delay the A-buffer has rows that are exposed evenly; --method sampled has others"};
  const auto asks = [](const Object& object) { return object.segments > 0; };
  if (scene.model.segments > 0 || std::any_of(scene.objects.begin(), scene.objects.end(), asks))
    return Error{"", "/image/segments",
                 "with a row delay the A-buffer cuts paths point by point, by \"motion\".\"tolerance_px\""};
  return Done{};
}

bool has_triangles(const Scene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(),
                     [](const Object& object) { return !object.triangles.empty(); });
}

/// What the sweep cannot do with triangles: discs that are seen in the same exposure.
Status check_meshes(const Scene& scene, const AbufferOptions& options) {
  if (!has_triangles(scene)) {
    if (options.place_intervals == 0) return Done{};
    return Error{"", "place_intervals", "is for triangles, and the scene has none", ErrorKind::unsupported};
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (scene.objects[i].discs() > 0)
      return Error{"", "/objects/" + std::to_string(i),
                   "is made of discs, which the A-buffer does not draw together with triangles; --method "
                   "sampled does",
                   ErrorKind::unsupported};
  if (Status status = refuse_looks(scene, "the A-buffer on triangles"); !status) return status;
  if (options.normalisation != Normalisation::interval)
    return Error{"", "normalisation",
                 "of the whole pixel is for discs; a scene of triangles has that of the interval",
                 ErrorKind::unsupported};
  return Done{};
}

/// A scene in which nothing moves. What the sweep counts did not happen.
Result<Rendered> render_still(const Scene& scene, const AbufferOptions& options,
                              const RenderControl& control) {
  Result<Rendered> rendered = render_standing(scene, options, control);
  if (!rendered) return rendered;
  Statistics& s = rendered->statistics;
  const std::vector<float>& depth = rendered->image.depth;
  s.count("pixels_still", static_cast<double>(std::count_if(depth.begin(), depth.end(), [](float z) {
            return z < std::numeric_limits<float>::infinity();
          })));
  for (const char* name : {"kernels", "kernels_edge_on", "kernels_at_near_plane", "culled_degenerate",
                           "fragments", "pixels_swept", "intervals", "intervals_cut_by_crossings",
                           "intervals_subdivided", "intervals_at_shortest", "integrals", "hidden_revealed"})
    s.count(name, 0.0);
  return rendered;
}

/// Every fragment of every pixel over the exposure.
Result<Rendered> render_swept(const Scene& scene, const AbufferOptions& options, const RenderControl& control,
                              DeepStore* deep) {
  Rendered out;
  Stopwatch watch;
  const KernelSet set = build_kernels(scene, scene.exposure(), control.stop);
  throw_if_stopped(control.stop);
  out.statistics.time("kernels", watch.lap());

  out.image = blank_image(scene.film);
  if (deep != nullptr) deep->start(out.image);
  const Window film{out.image.x, out.image.y, out.image.width, out.image.height};
  const TileBins bins(set, film, options.tile_px, control.stop);
  const std::vector<Shade> shades = shades_of(set);
  const std::vector<ShadeChange> changes = changes_of(set, shades);
  out.statistics.time("bins", watch.lap());
  // Points that stand still in a cloud that moves are not in it, and then it is of no use.
  std::optional<Image> standing;
  if (set.standing_kernels > 0 && set.standing_kernels == set.still_kernels) {
    Result<Rendered> rendered =
        render_standing(scene, options, {.threads = control.threads, .stop = control.stop});
    if (!rendered) return rendered;
    standing = std::move(rendered->image);
    out.statistics.time("what stands still", watch.lap());
  }

  PerThread<TileRenderer> renderers([&] {
    return TileRenderer(scene, set, shades, changes, options, control.stop, standing ? &*standing : nullptr,
                        out.image, deep);
  });
  ProgressOf done(control, bins.tile_count());
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, bins.tile_count(), 1), [&](const auto& range) {
    TileRenderer& renderer = renderers.local();
    for (std::size_t tile = range.begin(); tile != range.end(); ++tile) {
      if (control.stop.stop_requested()) return;
      renderer.render(bins.window(tile), bins.kernels(tile));
      done.one_more();
    }
  });
  if (control.stop.stop_requested()) return stopped_error();
  SweepCounts total;
  for (const TileRenderer& renderer : renderers) total.add(renderer.counters);
  out.statistics.time("tiles", watch.lap());
  out.statistics.time("rasterize, all threads", total.seconds_rasterize);
  out.statistics.time("resolve, all threads", total.seconds_resolve);
  describe(set, bins, total, out.statistics);
  return out;
}

Result<Rendered> render_checked(const Scene& scene, const AbufferOptions& options,
                                const RenderControl& control, DeepStore* deep) {
  const bool per_interval = options.normalisation == Normalisation::interval;
  const Exposure exposure = scene.exposure();
  const bool lens = scene.camera.aperture.radius > 0.0;
  if (lens)
    if (Status status = refuse_row_delay(scene, "a lens"); !status) return status.error();
  // Rows at instants of their own are stills, too.
  if (exposure.row_delay != 0.0 && exposure.instant()) return render_still(scene, options, control);
  const bool still = per_interval && nothing_moves(scene, exposure);
  std::optional<Rendered> picture;
  if (still) {
    Result<Rendered> rendered = render_still(scene, options, control);
    if (!rendered || deep == nullptr) return rendered;
    picture = *std::move(rendered);
  }
  // A still picture that is asked for by depth is taken apart besides.
  const RenderControl within{.threads = control.threads, .stop = control.stop};
  const RenderControl& rest = still ? within : control;
  if (!lens && has_triangles(scene)) return render_exact_meshes(scene, options, control);
  Result<Rendered> rendered =
      !lens ? render_swept(scene, options, rest, deep)
            : render_through_lens(scene, rest, [&](const Scene& pinhole, const RenderControl& part) {
                return still ? render_swept(pinhole, options, part, deep)
                             : render_checked(pinhole, options, part, deep);
              });
  if (rendered && picture) return *std::move(picture);
  return rendered;
}

}  // namespace

Status AbufferOptions::validate() const {
  if (tile_px < 1 || tile_px > 4096) return Error{"", "tile_px", "must be in [1, 4096]"};
  if (tile_fragments == 0) return Error{"", "tile_fragments", "must be at least 1"};
  if (place_intervals > 65536) return Error{"", "place_intervals", "must be in [0, 65536]"};
  if (deep && normalisation != Normalisation::interval)
    return Error{"", "deep", "goes with Normalisation::interval alone"};
  return Done{};
}

Result<Rendered> render_abuffer(const Scene& scene, const AbufferOptions& options,
                                const RenderControl& control) {
  if (Status status = refuse_splats(scene, "the A-buffer"); !status) return status.error();
  if (Status status = check_rows(scene); !status) return status.error();
  if (Status status = check_meshes(scene, options); !status) return status.error();
  if (Status status = refuse_textures(scene, "the A-buffer"); !status) return status.error();
  if (options.deep)
    if (Status status = refuse_triangles(scene, "the A-buffer in a deep image"); !status)
      return status.error();
  if (options.deep && scene.shutter.row_delay != 0.0 && scene.exposure().instant())
    return Error{"", "deep", "goes with a row delay only where the shutter is open for some time",
                 ErrorKind::unsupported};
  DeepStore store;
  DeepStore* const deep = options.deep ? &store : nullptr;
  Result<Rendered> rendered =
      render_valid(scene, options, control,
                   [deep](const Scene& valid, const AbufferOptions& as_asked, const RenderControl& within) {
                     return render_checked(valid, as_asked, within, deep);
                   });
  if (!rendered || !options.deep) return rendered;
  return without_throwing("for the samples by depth", [&]() -> Result<Rendered> {
    rendered->deep = store.finish(rendered->image, scene.background.cast<double>());
    rendered->statistics.count("deep_samples", static_cast<double>(rendered->deep->sample_count()));
    return std::move(rendered);
  });
}

}  // namespace swept
