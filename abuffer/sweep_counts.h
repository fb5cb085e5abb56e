// What the exact method counts, thread by thread. For the project's own sources.
#pragma once

#include <algorithm>
#include <cstdint>

#include "abuffer/exact_meshes.h"
#include "abuffer/resolve/surfaces.h"
#include "abuffer/sources/disc_fragments.h"
#include "splat/rendered.h"

namespace swept {

struct SweepCounts {
  std::uint64_t fragments = 0, still_pixels = 0, swept_pixels = 0, most_fragments = 0, split_tiles = 0;
  std::uint64_t pixels_of_several_meshes = 0, pixels_of_both = 0;  ///< both: discs and triangles
  std::uint64_t most_held = 0;                                     ///< intervals of triangles at once
  double seconds_rasterize = 0.0, seconds_resolve = 0.0;
  SweepCounters sweep;
  PlaceCounters places;

  void add(const SweepCounts& other) {
    fragments += other.fragments;
    still_pixels += other.still_pixels;
    swept_pixels += other.swept_pixels;
    most_fragments = std::max(most_fragments, other.most_fragments);
    split_tiles += other.split_tiles;
    most_held = std::max(most_held, other.most_held);
    pixels_of_several_meshes += other.pixels_of_several_meshes;
    pixels_of_both += other.pixels_of_both;
    places.add(other.places);
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

/// What a scene has of discs, which may be null, and of meshes, likewise.
void describe(const DiscFilm* discs, const MeshFilm* meshes, const SweepCounts& counts, Statistics& out);

}  // namespace swept
