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
#include "abuffer/parallel.h"
#include "abuffer/progress_of.h"
#include "abuffer/render_valid.h"
#include "abuffer/sampled.h"
#include "abuffer/through_lens.h"
#include "abuffer/tile_renderer.h"
#include "abuffer/tiles/tile_grid.h"
#include "splat/motion/segments.h"
#include "splat/stopwatch.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

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
        "with a row delay the A-buffer has rows that are exposed evenly; --method sampled has others",
        ErrorKind::unsupported};
  const auto asks = [](const Object& object) { return object.segments > 0; };
  if (scene.model.segments > 0 || std::any_of(scene.objects.begin(), scene.objects.end(), asks))
    return Error{"", "/image/segments",
                 "with a row delay the A-buffer cuts paths point by point, by \"motion\".\"tolerance_px\"",
                 ErrorKind::unsupported};
  return Done{};
}

bool has_discs(const Scene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(),
                     [](const Object& object) { return object.discs() > 0; });
}

bool has_triangles(const Scene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(),
                     [](const Object& object) { return !object.triangles.empty(); });
}

/// What the sweep cannot do with triangles.
Status check_meshes(const Scene& scene, const AbufferOptions& options) {
  if (!has_triangles(scene)) {
    if (options.place_intervals == 0) return Done{};
    return Error{"", "place_intervals", "is for triangles, and the scene has none", ErrorKind::unsupported};
  }
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
  out.image = blank_image(scene.film);
  if (deep != nullptr)
    if (Status begun = deep->start(out.image); !begun) return begun.error();
  const Window window{out.image.x, out.image.y, out.image.width, out.image.height};
  TileWork work{.model = SurfaceModel(scene.model, options.normalisation),
                .model_by_interval = SurfaceModel(scene.model),
                .simd = options.simd,
                .stop = control.stop};
  std::size_t kept = 0;
  std::optional<MeshFilm> meshes;
  if (has_triangles(scene)) {
    Result<MeshFilm> film = MeshFilm::follow(scene, window, options, control.stop);
    if (!film) return film.error();
    work.meshes = &meshes.emplace(*std::move(film));
    kept = bytes_of(*meshes);
    if (Status fits = check_bytes(kept, control, "the triangles' paths and tiles"); !fits)
      return fits.error();
    out.statistics.time("paths", watch.lap());
  }
  std::optional<DiscFilm> discs;
  std::optional<Image> standing;
  if (has_discs(scene) || !work.meshes) {
    work.discs =
        &discs.emplace(scene, window, options.parabolas ? SegmentShape::parabolas : SegmentShape::chords,
                       options.tile_px, options.tile_fragments, control.stop, control.max_bytes);
    kept += discs->bins.bytes();
    if (Status fits = check_bytes(kept, control, "the tiles' lists of what comes by"); !fits)
      return fits.error();
    out.statistics.time("kernels", watch.lap());
    // Points that stand still in a cloud that moves are not in it, and then it is of no use.
    const KernelCounts& kernels = discs->counts;
    if (!work.meshes && kernels.standing_kernels > 0 && kernels.standing_kernels == kernels.still_kernels) {
      Result<Rendered> rendered = render_standing(
          scene, options, {.threads = control.threads, .max_bytes = control.max_bytes, .stop = control.stop});
      if (!rendered) return rendered;
      work.standing = &standing.emplace(std::move(rendered->image));
      out.statistics.time("what stands still", watch.lap());
    }
  }

  const FilmSink film(out.image, scene.background, deep);
  PerThread<TileRenderer> renderers([&] { return TileRenderer(work, film); });
  const TileGrid tiles(window, options.tile_px);
  ProgressOf done(control, tiles.count());
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, tiles.count(), 1), [&](const auto& range) {
    TileRenderer& renderer = renderers.local();
    for (std::size_t tile = range.begin(); tile != range.end(); ++tile) {
      if (control.stop.stop_requested() || (deep != nullptr && deep->full())) return;
      const std::size_t before = film.deep_bytes(tiles.window(tile));
      renderer.render(tile, tiles.window(tile));
      if (deep != nullptr) deep->changed(before, film.deep_bytes(tiles.window(tile)));
      done.one_more();
    }
  });
  if (control.stop.stop_requested()) return stopped_error();
  if (deep != nullptr && deep->full()) return deep->full_error();
  SweepCounts total;
  for (const TileRenderer& renderer : renderers) total.add(renderer.counts());
  out.statistics.time("tiles", watch.lap());
  out.statistics.time("rasterize, all threads", total.seconds_rasterize);
  out.statistics.time("resolve, all threads", total.seconds_resolve);
  describe(work.discs, work.meshes, total, out.statistics);
  out.statistics.count("kept_bytes", static_cast<double>(kept));
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
  // Of triangles the sweep is the more precise, and what it is taken apart into flattens to its own picture.
  const bool swept_by_depth = deep != nullptr && has_triangles(scene);
  const bool still = per_interval && !swept_by_depth && nothing_moves(scene, exposure);
  std::optional<Rendered> picture;
  if (still) {
    Result<Rendered> rendered = render_still(scene, options, control);
    if (!rendered || deep == nullptr) return rendered;
    picture = *std::move(rendered);
  }
  // A still picture that is asked for by depth is taken apart besides.
  const RenderControl within{
      .threads = control.threads, .max_bytes = control.max_bytes, .stop = control.stop};
  const RenderControl& rest = still ? within : control;
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
  if (options.deep && scene.shutter.row_delay != 0.0 && scene.exposure().instant())
    return Error{"", "deep", "goes with a row delay only where the shutter is open for some time",
                 ErrorKind::unsupported};
  DeepStore store(control.max_bytes);
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
