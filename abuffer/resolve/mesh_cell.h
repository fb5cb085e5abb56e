// The triangles of one mesh in one cell of the film at an instant. Source: model section 15.
#pragma once

#include <cstdint>
#include <vector>

#include "abuffer/resolve/sampled_cell.h"
#include "abuffer/sources/placed_triangle.h"

namespace swept {

/// A thread's: memory is kept from cell to cell.
class MeshCell {
 public:
  /// Appends what the mesh shows in the cell's pixels: its first surface, and where that lets light through
  /// those behind it.
  void add(const MeshInstant& mesh, const Cell& cell, std::size_t index,
           std::vector<SampledCell::Surface>& surfaces);

  std::uint64_t fragments = 0;  ///< pairs of a triangle and a pixel that it touches

 private:
  struct Fragment {
    std::uint32_t placed;  ///< triangle
    std::uint16_t pixel;   ///< of cell_px × cell_px
    std::uint16_t mask;    ///< places where the triangle is met
  };

  void draw(const PlacedTriangle& placed, std::uint32_t index, const FilmBox& box, const Cell& cell);
  void shade(std::uint32_t pixel, std::size_t begin, std::size_t end, const Cell& cell, bool opaque,
             std::vector<SampledCell::Surface>& surfaces) const;

  std::vector<PlacedTriangle> placed_;
  std::vector<Fragment> fragments_, sorted_;
  std::vector<std::uint32_t> starts_;
};

}  // namespace swept
