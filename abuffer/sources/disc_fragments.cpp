#include "abuffer/sources/disc_fragments.h"

#include <utility>

#include "splat/kernel/screen_bounds.h"

namespace swept {

DiscFilm::DiscFilm(const Scene& scene, KernelSet kernels, const Window& window, int tile_px,
                   std::size_t limit, const std::stop_token& stop)
    : set(std::move(kernels)),
      bins(set, window, tile_px, stop),
      shades(shades_of(set)),
      changes(changes_of(set, shades)),
      raster{set.projection, set.near, scene.model.delta,
             static_cast<std::uint32_t>(shades.size() - set.kernels.size()),
             scene.shutter.row_delay == 0.0
                 ? 0.0
                 : scene.shutter.row_delay / (scene.shutter.close - scene.shutter.open)},
      fragment_limit(limit) {}

void DiscFragments::select(std::size_t tile) {
  octagons_.clear();
  for (const std::uint32_t k : film_.bins.kernels(tile)) {
    Octagon octagon;
    if (screen_bounds(film_.set.kernels[k], film_.set.projection, film_.set.near, octagon))
      octagons_.push_back({k, octagon});
  }
}

bool DiscFragments::gather(const Window& window) {
  std::size_t bound = 0;
  for (const BoundedKernel& kernel : octagons_) bound += visited_pixels(kernel.octagon, window);
  if (bound > film_.fragment_limit && window.width * window.height > 1) return false;
  fragments_.count = 0;
  for (const BoundedKernel& kernel : octagons_)
    rasterize(film_.set.kernels[kernel.index], kernel.index, kernel.octagon, film_.raster, window,
              fragments_);
  sort_by_pixel(window);
  return true;
}

/// A stable counting sort of fragment indices: within a pixel they keep the order of the kernels.
void DiscFragments::sort_by_pixel(const Window& window) {
  const std::size_t pixels = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
  starts_.assign(pixels + 1, 0);
  moving_.assign(pixels, 0);
  for (std::size_t i = 0; i < fragments_.count; ++i) {
    ++starts_[fragments_.pixel[i] + 1];
    if (!is_still(fragments_, i)) moving_[fragments_.pixel[i]] = 1;
  }
  changing_.assign(film_.changes.empty() ? 0 : pixels, 0);
  for (std::size_t i = 0; i < fragments_.count && !film_.changes.empty(); ++i)
    if (film_.changes[fragments_.kernel[i]].any())
      moving_[fragments_.pixel[i]] = changing_[fragments_.pixel[i]] = 1;
  for (std::size_t p = 0; p < pixels; ++p) starts_[p + 1] += starts_[p];
  sorted_.resize(fragments_.count);
  fill_.assign(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < fragments_.count; ++i)
    sorted_[fill_[fragments_.pixel[i]]++] = static_cast<std::uint32_t>(i);
}

}  // namespace swept
