// Which kernels touch which tile, by where they come from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "abuffer/sources/rasterize.h"
#include "abuffer/tiles/tile_grid.h"
#include "splat/kernel/kernel_maker.h"

namespace swept {

class TileBins {
 public:
  TileBins(const Window& film_window, int tile_px, const Projection& projection, double near);

  /// Puts it into every tile that it touches.
  void add(const KernelSource& source, const MovingKernel& kernel, const DiscTurn* turn);

  /// In any order.
  template <class Visit>
  void for_each(std::size_t tile, const Visit& visit) const {
    std::size_t count = last_[tile].count;
    for (std::uint32_t b = last_[tile].block; b != no_block; b = blocks_[b].before) {
      for (std::size_t i = 0; i < count; ++i) visit(blocks_[b].sources[i]);
      count = per_block;
    }
  }
  /// Whether any of them moves, changes its colour, or is not there all the time.
  [[nodiscard]] bool moves(std::size_t tile) const { return last_[tile].moves; }
  [[nodiscard]] std::size_t entry_count() const { return entries_; }
  /// What they take.
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.size() * sizeof(Block) + last_.size() * sizeof(Last);
  }
  [[nodiscard]] std::size_t outside() const { return outside_; }  ///< kernels that touch no pixel
  [[nodiscard]] std::size_t facing_away() const {
    return facing_away_;
  }  ///< seen from behind wherever they are

 private:
  static constexpr std::size_t per_block = 31;
  static constexpr std::uint32_t no_block = ~0u;
  /// A tile's, linked: a vector for each tile would be half empty, and a pass that counts first would have to
  /// make all kernels twice.
  struct Block {
    std::array<KernelSource, per_block> sources;
    std::uint32_t before;
  };
  struct Last {
    std::uint32_t block = no_block, count = per_block;
    bool moves = false;
  };
  void put(std::size_t tile, const KernelSource& source);

  TileGrid tiles_;
  Window film_;
  int tile_px_;
  Projection projection_;
  double near_;
  std::vector<Last> last_;
  std::deque<Block> blocks_;
  std::size_t entries_ = 0, outside_ = 0, facing_away_ = 0;
};

}  // namespace swept
