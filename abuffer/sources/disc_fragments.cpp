#include "abuffer/sources/disc_fragments.h"

#include <algorithm>

#include "splat/kernel/turning_kernel.h"
#include "splat/without_throwing.h"

namespace swept {

DiscFilm::DiscFilm(const Scene& scene, const Window& window, SegmentShape shape, int tile_px,
                   std::size_t limit, const std::stop_token& stop, std::size_t max_bytes)
    : maker(scene, scene.exposure(), shape),
      bins(window, tile_px, maker.projection(), maker.near()),
      raster{maker.projection(), maker.near(), scene.model.delta, 0,
             scene.shutter.row_delay == 0.0
                 ? 0.0
                 : scene.shutter.row_delay / (scene.shutter.close - scene.shutter.open)},
      fragment_limit(limit) {
  counts = maker.make_all(
      [&](const KernelSource& source, const MovingKernel& kernel, const DiscTurn* turn) {
        if (max_bytes > 0 && bins.bytes() > max_bytes) return;
        ++kernels;
        order.include(kernel);
        bins.add(source, kernel, turn);
      },
      stop);
  throw_if_stopped(stop);
}

void DiscFragments::select(std::size_t tile) {
  octagons_.clear();
  kernels_.clear();
  turns_.clear();
  film_.bins.for_each(tile, [&](const KernelSource& source) {
    std::optional<DiscTurn> turn;
    const MovingKernel kernel = film_.maker.make(source, turn);
    Octagon octagon;
    if (!bounds_of(kernel, turn ? &*turn : nullptr, film_.raster.projection, film_.raster.near, octagon))
      return;
    octagons_.push_back({film_.order.key(kernel), static_cast<std::uint32_t>(kernels_.size()),
                         turn ? static_cast<std::uint32_t>(turns_.size()) : no_turn, octagon});
    kernels_.push_back(kernel);
    if (turn) turns_.push_back(*turn);
  });
  std::sort(octagons_.begin(), octagons_.end(),
            [&](const BoundedKernel& a, const BoundedKernel& b) { return before(a, b); });
  shades_ = shades_of(kernels_);
  changes_ = changes_of(kernels_, shades_);
  tolerances_change_ = std::any_of(kernels_.begin(), kernels_.end(),
                                   [](const MovingKernel& k) { return k.tolerance_rate != 0.0f; });
  raster_.backs = static_cast<std::uint32_t>(shades_.size() - kernels_.size());
}

Window DiscFragments::keep_what_moves(const Window& window) {
  Window moved{window.x, window.y, 0, 0};
  for (const BoundedKernel& kernel : octagons_)
    if (kernel.turn != no_turn || !kernels_[kernel.index].stays())
      moved = moved.joined(part_within(kernel.octagon, window));
  const PixelBox box = moved.centers();
  std::erase_if(octagons_, [&](const BoundedKernel& kernel) { return !kernel.octagon.overlaps(box); });
  return moved;
}

bool DiscFragments::before(const BoundedKernel& a, const BoundedKernel& b) const {
  if (a.key != b.key) return a.key < b.key;
  if (KernelOrder::content_less(kernels_[a.index], kernels_[b.index])) return true;
  const DiscTurn *turn_a = turn_of(a), *turn_b = turn_of(b);
  if ((turn_a == nullptr && turn_b == nullptr) ||
      KernelOrder::content_less(kernels_[b.index], kernels_[a.index]))
    return false;
  return turn_a == nullptr || (turn_b != nullptr && turn_a->content() < turn_b->content());
}

bool DiscFragments::gather(const Window& window) {
  std::size_t bound = 0;
  for (const BoundedKernel& kernel : octagons_) bound += visited_pixels(kernel.octagon, window);
  if (bound > film_.fragment_limit && window.width * window.height > 1) return false;
  fragments_.count = 0;
  for (const BoundedKernel& kernel : octagons_)
    rasterize(kernels_[kernel.index], turn_of(kernel), kernel.index, kernel.octagon, raster_, window,
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

}  // namespace swept
