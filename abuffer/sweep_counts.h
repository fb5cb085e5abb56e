// What the exact method counts, thread by thread. For the project's own sources.
#pragma once

#include <algorithm>
#include <cstdint>

#include "abuffer/resolve/surfaces.h"
#include "abuffer/tiles/bins.h"
#include "splat/kernel/kernel_set.h"
#include "splat/rendered.h"

namespace swept {

struct SweepCounts {
  std::uint64_t fragments = 0, still_pixels = 0, swept_pixels = 0, most_fragments = 0, split_tiles = 0;
  double seconds_rasterize = 0.0, seconds_resolve = 0.0;
  SweepCounters sweep;

  void add(const SweepCounts& other) {
    fragments += other.fragments;
    still_pixels += other.still_pixels;
    swept_pixels += other.swept_pixels;
    most_fragments = std::max(most_fragments, other.most_fragments);
    split_tiles += other.split_tiles;
    seconds_rasterize += other.seconds_rasterize;
    seconds_resolve += other.seconds_resolve;
    sweep.intervals += other.sweep.intervals;
    sweep.crossings += other.sweep.crossings;
    sweep.subdivided += other.sweep.subdivided;
    sweep.evaluations += other.sweep.evaluations;
    sweep.hidden += other.sweep.hidden;
    sweep.revealed += other.sweep.revealed;
    sweep.merged += other.sweep.merged;
    sweep.retried += other.sweep.retried;
    sweep.shortest += other.sweep.shortest;
  }
};

inline void describe(const KernelSet& set, const TileBins& bins, const SweepCounts& c, Statistics& s) {
  const double swept = static_cast<double>(std::max<std::uint64_t>(1, c.swept_pixels));
  s.count("surfels", static_cast<double>(set.surfels));
  s.count("kernels", static_cast<double>(set.kernels.size()));
  s.count("segments", set.most_segments);
  s.count("kernels_still", static_cast<double>(set.still_kernels));
  s.count("kernels_edge_on", static_cast<double>(set.edge_on_kernels));
  s.count("kernels_at_near_plane", static_cast<double>(set.near_kernels));
  s.count("culled_degenerate", static_cast<double>(set.culled_degenerate));
  s.count("culled_near", static_cast<double>(set.culled_near));
  s.count("culled_outside", static_cast<double>(bins.outside()));
  s.count("culled_facing_away", static_cast<double>(bins.facing_away()));
  s.count("tile_entries", static_cast<double>(bins.entry_count()));
  s.count("tiles_split", static_cast<double>(c.split_tiles));
  s.count("fragments", static_cast<double>(c.fragments));
  s.count("fragments_in_fullest_pixel", static_cast<double>(c.most_fragments));
  s.count("pixels_still", static_cast<double>(c.still_pixels));
  s.count("pixels_swept", static_cast<double>(c.swept_pixels));
  s.count("intervals", static_cast<double>(c.sweep.intervals));
  s.count("intervals_per_swept_pixel", static_cast<double>(c.sweep.intervals) / swept);
  s.count("intervals_merged", static_cast<double>(c.sweep.merged));
  s.count("intervals_retried", static_cast<double>(c.sweep.retried));
  s.count("intervals_cut_by_crossings", static_cast<double>(c.sweep.crossings));
  s.count("intervals_subdivided", static_cast<double>(c.sweep.subdivided));
  s.count("intervals_at_shortest", static_cast<double>(c.sweep.shortest));
  s.count("integrals", static_cast<double>(c.sweep.evaluations));
  s.count("fragments_hidden", static_cast<double>(c.sweep.hidden));
  s.count("hidden_revealed", static_cast<double>(c.sweep.revealed));
  s.effect(c.swept_pixels > 0 ? "motion blur: swept where something moves"
                              : "motion blur: skipped, nothing moves during the exposure");
}

}  // namespace swept
