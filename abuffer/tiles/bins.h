// Which kernels touch which tile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "abuffer/sources/rasterize.h"
#include "abuffer/tiles/tile_grid.h"
#include "splat/kernel/kernel_set.h"

namespace swept {

class TileBins {
 public:
  /// Bins all kernels that touch `film_window`, in their order. Throws Stopped once `stop` asks for it.
  TileBins(const KernelSet& set, const Window& film_window, int tile_px, const std::stop_token& stop);

  [[nodiscard]] std::size_t tile_count() const { return starts_.size() - 1; }
  [[nodiscard]] Window window(std::size_t tile) const { return tiles_.window(tile); }
  /// Indices into the kernel set, increasing.
  [[nodiscard]] std::span<const std::uint32_t> kernels(std::size_t tile) const {
    return {entries_.data() + starts_[tile], entries_.data() + starts_[tile + 1]};
  }
  [[nodiscard]] std::size_t entry_count() const { return entries_.size(); }
  [[nodiscard]] std::size_t outside() const { return outside_; }  ///< kernels that touch no pixel
  [[nodiscard]] std::size_t facing_away() const {
    return facing_away_;
  }  ///< seen from behind wherever they are

 private:
  TileGrid tiles_;
  std::vector<std::size_t> starts_;
  std::vector<std::uint32_t> entries_;
  std::size_t outside_ = 0, facing_away_ = 0;
};

}  // namespace swept
