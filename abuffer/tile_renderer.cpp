#include "abuffer/tile_renderer.h"

#include <algorithm>
#include <limits>

#include "splat/stopwatch.h"

namespace swept {

TileRenderer::TileRenderer(const TileWork& work, const FilmSink& film)
    : work_(work),
      film_(film),
      pixel_(work.model, work.simd ? interval_math_builds().back() : interval_math_builds().front(),
             work.stop),
      still_by_interval_(work.model_by_interval),
      copies_standing_(work.standing != nullptr && !work.model.per_pixel() && !film.wants_depths()) {
  if (work.discs != nullptr) discs_.emplace(*work.discs, work.simd);
  if (work.meshes != nullptr) meshes_.emplace(*work.meshes);
}

SweepCounts TileRenderer::counts() const {
  SweepCounts all = counters_;
  all.places = pixel_.places();
  if (meshes_) all.most_held = meshes_->most_held();
  all.pixels_of_several_meshes = pixel_.pixels_of_several_meshes;
  return all;
}

void TileRenderer::render(std::size_t tile, const Window& window) {
  if (copies_standing_) {
    const Window moved = select_what_moves(tile, window);
    if (!moved.empty()) render_part(moved, true);
    return;
  }
  if (discs_) discs_->select(tile);
  if (meshes_) meshes_->select(tile);
  render_part(window, true);
}

/// The part of the window that is left to be rendered. Nothing is generated for the rest.
Window TileRenderer::select_what_moves(std::size_t tile, const Window& window) {
  Window moved{window.x, window.y, 0, 0};
  if (discs_->film().bins.moves(tile)) {
    discs_->select(tile);
    moved = discs_->keep_what_moves(window);
  }
  for (int y = window.y; y < window.y + window.height; ++y)
    for (int x = window.x; x < window.x + window.width; ++x)
      if (!moved.contains(x, y)) copy_standing(x, y);
  return moved;
}

/// 0: its fragments fit. Else how often it has to be halved, as far as can be told.
int TileRenderer::gather(const Window& window) {
  if (discs_ && !discs_->gather(window)) return 1;
  return meshes_ && !meshes_->gather(window) ? meshes_->halvings() : 0;
}

/// Halves the window, so many times before it is looked at, and until its fragments fit; a single pixel's
/// always do.
void TileRenderer::render_part(const Window& window, bool whole, int halvings) {
  if (work_.stop.stop_requested()) return;
  if (halvings == 0 || window.width * window.height == 1) {
    Stopwatch watch;
    halvings = gather(window);
    counters_.seconds_rasterize += watch.lap();
    if (halvings == 0) {
      resolve(window);
      counters_.seconds_resolve += watch.lap();
      return;
    }
    if (whole) ++counters_.split_tiles;
  }
  const auto [first, second] = window.halves();
  render_part(first, false, halvings - 1);
  render_part(second, false, halvings - 1);
}

void TileRenderer::resolve(const Window& window) {
  if (work_.stop.stop_requested()) return;
  if (discs_) counters_.fragments += discs_->fragments().count;
  if (meshes_) counters_.fragments += meshes_->interval_count();
  std::size_t local = 0;
  for (int y = window.y; y < window.y + window.height; ++y)
    for (int x = window.x; x < window.x + window.width; ++x, ++local) {
      if (work_.stop.stop_requested()) return;
      resolve_pixel(window, x, y, local);
    }
}

void TileRenderer::resolve_pixel(const Window& window, int x, int y, std::size_t local) {
  PixelSum pixel = film_.begin(x, y);
  const std::span<std::uint32_t> indices = discs_ ? discs_->of_pixel(local) : std::span<std::uint32_t>();
  const std::span<PlaceInterval> intervals = meshes_ ? meshes_->of_pixel(local) : std::span<PlaceInterval>();
  counters_.most_fragments =
      std::max<std::uint64_t>(counters_.most_fragments, indices.size() + intervals.size());
  const auto discs = [&] {
    DiscsOfPixel of{discs_->fragments(), discs_->shades(), indices};
    if (discs_->changes_color(local)) of.changes.of = discs_->changes().data();
    of.changes.later = discs_->film().raster.row_delay * y;
    of.changes.tolerances = discs_->tolerances_change();
    return of;
  };
  if (!intervals.empty()) {
    ++counters_.swept_pixels;
    const PlaceRays rays = meshes_->rays(x, y);
    const TrianglesOfPixel triangles{intervals, meshes_->triangles(), rays, meshes_->light(y - window.y)};
    if (indices.empty()) {
      pixel_.add(triangles, pixel);
    } else {
      ++counters_.pixels_of_both;
      pixel_.add(discs(), triangles, pixel, counters_.sweep);
    }
  } else if (!indices.empty() && discs_->moves(local)) {
    ++counters_.swept_pixels;
    pixel_.add(discs(), pixel, counters_.sweep);
  } else if (copies_standing_) {
    return copy_standing(x, y);
  } else if (!indices.empty()) {
    ++counters_.still_pixels;
    pixel_.add_still(discs(), pixel);
    if (work_.standing != nullptr) return store_standing(x, y, pixel, discs());
  }
  film_.store(x, y, pixel);
}

void TileRenderer::copy_standing(int x, int y) {
  film_.replace(x, y, *work_.standing, true);
  if (work_.standing->depth[film_.index_of(x, y)] < std::numeric_limits<float>::infinity())
    ++counters_.still_pixels;
}

/// Alpha and depth do not depend on the normalisation, nor does the colour of a single surface.
void TileRenderer::store_standing(int x, int y, const PixelSum& pixel, const DiscsOfPixel& discs) {
  film_.store(x, y, pixel);
  film_.replace(x, y, *work_.standing, false);
  if (work_.model.per_pixel()) {
    PixelSum by_interval;
    still_by_interval_.resolve(discs.fragments, discs.shades, discs.indices.data(), discs.indices.size(),
                               by_interval);
    for (int c = 0; c < 3; ++c)
      if (by_interval.rgba[c] != pixel.rgba[c]) return;
  }
  film_.replace(x, y, *work_.standing, true);
}

}  // namespace swept
