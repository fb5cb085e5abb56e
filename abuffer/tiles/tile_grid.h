// The tiles that a window of the film is cut into, row by row. For the project's own sources.
#pragma once

#include <algorithm>
#include <cstddef>

#include "abuffer/sources/rasterize.h"

namespace swept {

class TileGrid {
 public:
  TileGrid(const Window& film, int tile_px)
      : film_(film),
        tile_px_(tile_px),
        columns_(static_cast<std::size_t>((film.width + tile_px - 1) / tile_px)),
        rows_(static_cast<std::size_t>((film.height + tile_px - 1) / tile_px)) {}

  [[nodiscard]] std::size_t count() const { return columns_ * rows_; }
  [[nodiscard]] std::size_t columns() const { return columns_; }
  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] Window window(std::size_t tile) const {
    const int x = static_cast<int>(tile % columns_) * tile_px_,
              y = static_cast<int>(tile / columns_) * tile_px_;
    return {film_.x + x, film_.y + y, std::min(tile_px_, film_.width - x),
            std::min(tile_px_, film_.height - y)};
  }

 private:
  Window film_;
  int tile_px_;
  std::size_t columns_, rows_;
};

}  // namespace swept
