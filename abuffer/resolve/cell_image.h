// What the pixels of a cell of the film come to, and its way into a frame's image.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "abuffer/tiles/cells.h"
#include "splat/image.h"

namespace swept {

/// What the pixels of a cell add up to: over instants of weight 1 in all, premultiplied, without a
/// background.
struct CellImage {
  std::vector<double> rgba;   ///< 4 per pixel of cell_px × cell_px
  std::vector<double> depth;  ///< weighted by alpha
};

/// Whether any pixel of the cell is in the image's window.
[[nodiscard]] bool in_window(const Cell& cell, const Image& image);

/// Stores what of the cell is in the image's window, before a background.
void store_cell(const Cell& cell, const CellImage& pixels, const Eigen::Vector4f& background, Image& image);

/// Stores root mean squares over three colours into a channel of the image's window. `squares`: their sums,
/// of every pixel of cell_px × cell_px.
void store_cell_error(const Cell& cell, std::span<const float> squares, const Image& image,
                      std::vector<float>& channel);

}  // namespace swept
