// Splats in one cell of the film at one instant after another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "abuffer/resolve/sampled_cell.h"
#include "abuffer/simd/splat_math.h"
#include "abuffer/splats/splat_row.h"
#include "splat/image.h"

namespace swept {

/// What a cell's tiles add up to.
struct CellOfSplats {
  SplatSums tiles[tiles_a_cell] = {};

  [[nodiscard]] SampledCell::Squares squares(const Cell& cell) const;
  /// Makes the alternating sums those of all instants so far.
  void alternate_from_sums();
  /// The mean of instants of `total` weight, into `image`.
  void store(const Cell& cell, double total, float background_alpha, Image& image) const;
  /// What estimates count of an instant that is the only one so far, and was added without.
  void weigh(const InstantWeights& weights);
  /// The first instant's red, green and blue, into `rgba` of a whole film `width` wide.
  void copy_colors(const Cell& cell, int width, std::vector<float>& rgba) const;
  /// √ of a third of so much of every pixel's squared alternating sums, into a channel of `image`'s window.
  void store_error(const Cell& cell, double per_alternating, const Image& image,
                   std::vector<float>& channel) const;
};

/// A thread's: memory is kept from cell to cell.
class SplatPainter {
 public:
  SplatPainter(const SplatMath& math, const SplatRule& rule) : math_(math), rule_(rule) {}

  /// Adds the image at an instant: `standing` and `moving` are placed, and shared out to cell `index`.
  /// Between them come `surfaces`, in each pixel from the nearest to the farthest.
  void add(const Cell& cell, std::size_t index, const SplatRow& standing, const SplatRow& moving,
           const std::vector<SampledCell::Surface>& surfaces, const InstantWeights& weights,
           CellOfSplats& sums);

  std::uint64_t looks = 0;  ///< of a splat and a block of 16 pixels

 private:
  void merge(std::size_t index, const SplatRow& standing, const SplatRow& moving);
  void share_out(const Cell& cell, const PlacedSplat* const (&rows)[2]);
  [[nodiscard]] std::size_t gather_layers(const std::vector<SampledCell::Surface>& surfaces, int tile);
  void draw_among_surfaces(const SplatList& list, std::size_t layers, int x, int y);

  const SplatMath& math_;
  SplatRule rule_;
  SplatTile tile_;
  std::vector<std::uint32_t> merged_, of_tile_[tiles_a_cell];
  std::size_t counts_[tiles_a_cell] = {};
  std::vector<SurfaceLayer> layers_;
  std::vector<SplatTile> runs_;
};

[[nodiscard]] SplatRule splat_rule(const Scene& scene);

}  // namespace swept
