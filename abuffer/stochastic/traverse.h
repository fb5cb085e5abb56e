// The traversals (Gribel et al. 2013, section 4): which samples of a block a moving primitive is tested
// against. All find the same ones inside.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <tbb/task_group.h>

#include "abuffer/stochastic/film_reach.h"
#include "abuffer/stochastic/pixel_samples.h"
#include "abuffer/stochastic/sample_hits.h"
#include "abuffer/stochastic/stochastic.h"
#include "splat/without_throwing.h"

namespace swept::stochastic {

struct TraversalCounts {
  std::uint64_t tested = 0, inside = 0, bounds = 0;
};

/// The samples of a block and what they met.
struct Block {
  BlockSamples samples;
  SampleHits hits;
  TraversalCounts counts;
  std::uint64_t work = 0;  ///< since it was last asked whether to stop
  /// Of the parts of the exposure, where each begins, and the end: in shares of the light, and in time.
  std::vector<double> share_cuts, time_cuts;

  [[nodiscard]] std::size_t first_of(int x, int y) const {
    const Window& window = samples.window;
    return (static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.width) +
            static_cast<std::size_t>(x - window.x)) *
           static_cast<std::size_t>(samples.per_pixel);
  }
  void worked(std::uint64_t steps) {
    if ((work += steps) < 20000) return;
    work = 0;
    if (tbb::is_current_task_group_canceling()) throw Stopped();
  }
};

/// Tiles stand at multiples of their side on the film, so that crops see the same ones.
template <class Primitive>
void traverse_tiles(Primitive& primitive, int tile_px, CurveBounds bounds, Block& block) {
  const float* const times = Primitive::times(block.samples);
  const PixelRange window = range_of(block.samples.window);
  const auto count = static_cast<std::size_t>(block.samples.per_pixel);
  for (int p = 0; p < primitive.pieces(); ++p) {
    const PixelRange range = primitive.pixels(primitive.piece(p), window);
    if (range.empty()) continue;
    primitive.begin_tiles(p, range, tile_px, bounds);
    const auto floored = [&](int v) { return v - ((v % tile_px) + tile_px) % tile_px; };
    for (int ty = floored(range.y0); ty < range.y1; ty += tile_px)
      for (int tx = floored(range.x0); tx < range.x1; tx += tile_px) {
        ++block.counts.bounds;
        block.worked(20);
        const Span span = primitive.tile(tx, ty);
        if (span.empty()) continue;
        for (int y = std::max(ty, range.y0); y < std::min(ty + tile_px, range.y1); ++y)
          for (int x = std::max(tx, range.x0); x < std::min(tx + tile_px, range.x1); ++x) {
            const std::size_t first = block.first_of(x, y);
            const float* const begin = times + first;
            const auto before = [](float t, double limit) { return double{t} < limit; };
            std::size_t k = first + static_cast<std::size_t>(
                                        std::lower_bound(begin, begin + count, span.begin, before) - begin);
            for (; k < first + count && double{times[k]} <= span.end; ++k) {
              if (primitive.piece_of(times[k]) != p) continue;
              ++block.counts.tested;
              block.worked(1);
              if (primitive.test(block.samples, k, x, y, block.hits)) ++block.counts.inside;
            }
          }
      }
  }
}

template <class Primitive>
void traverse_intervals(Primitive& primitive, const std::vector<double>& cuts, Block& block) {
  const PixelRange window = range_of(block.samples.window);
  const auto count = static_cast<std::size_t>(block.samples.per_pixel);
  const std::size_t parts = cuts.size() - 1;
  const float* const shares = block.samples.share.data();
  for (std::size_t part = 0; part < parts; ++part) {
    ++block.counts.bounds;
    block.worked(20);
    // Times are floats of what the cuts are.
    const PixelRange range = primitive.pixels({cuts[part] - 1e-6, cuts[part + 1] + 1e-6}, window);
    const std::size_t from = part * count / parts,
                      to = std::min(count, ((part + 1) * count + parts - 1) / parts + 1);
    const auto own = [&](float share) {
      return std::min(static_cast<std::size_t>(double{share} * static_cast<double>(parts)), parts - 1) ==
             part;
    };
    for (int y = range.y0; y < range.y1; ++y)
      for (int x = range.x0; x < range.x1; ++x) {
        const std::size_t first = block.first_of(x, y);
        for (std::size_t k = first + (from > 0 ? from - 1 : 0); k < first + to; ++k) {
          if (!own(shares[k])) continue;
          ++block.counts.tested;
          block.worked(1);
          if (primitive.test(block.samples, k, x, y, block.hits)) ++block.counts.inside;
        }
      }
  }
}

template <class Primitive>
void traverse_interleaved(Primitive& primitive, const SampleSource& source, Block& block) {
  const PixelRange window = range_of(block.samples.window);
  const auto count = static_cast<std::size_t>(block.samples.per_pixel),
             times = static_cast<std::size_t>(source.times());
  const bool by_share = Primitive::times(block.samples) == block.samples.share.data();
  for (std::size_t instant = 0; instant < times; ++instant) {
    ++block.counts.bounds;
    block.worked(20);
    const float share = source.instant_share(static_cast<int>(instant));
    const float time = by_share ? share : source.time_of(double{share});
    const PixelRange range = primitive.pixels({double{time}, double{time}}, window);
    if (range.empty()) continue;
    primitive.place(time);
    const std::size_t from = instant * count / times,
                      to = std::min(count, ((instant + 1) * count + times - 1) / times + 1);
    for (int y = range.y0; y < range.y1; ++y)
      for (int x = range.x0; x < range.x1; ++x) {
        const std::size_t first = block.first_of(x, y);
        block.worked(1);
        for (std::size_t k = first + (from > 0 ? from - 1 : 0); k < first + to; ++k) {
          if (block.samples.instant[k] != instant) continue;
          ++block.counts.tested;
          block.worked(1);
          if (primitive.test_placed(block.samples, k, x, y, block.hits)) ++block.counts.inside;
        }
      }
  }
}

template <class Primitive>
void traverse(Primitive& primitive, const StochasticOptions& options, const SampleSource& source,
              Block& block) {
  switch (options.traversal) {
    case Traversal::tile:
      return traverse_tiles(primitive, options.tile_px, options.bounds, block);
    case Traversal::interval:
      return traverse_intervals(
          primitive,
          Primitive::times(block.samples) == block.samples.share.data() ? block.share_cuts : block.time_cuts,
          block);
    case Traversal::interleave:
      return traverse_interleaved(primitive, source, block);
    case Traversal::automatic:  // chosen before
    case Traversal::hierarchy:
      return;  // not primitive by primitive
  }
}

}  // namespace swept::stochastic
