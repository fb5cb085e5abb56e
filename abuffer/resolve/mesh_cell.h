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
  explicit MeshCell(const MeshMath& math) : math_(math) {}

  /// Appends what the mesh shows in the cell's pixels: its first surface, and where that lets light through
  /// those behind it.
  void add(const MeshInstant& mesh, const Cell& cell, std::size_t index,
           std::vector<SampledCell::Surface>& surfaces);

 private:
  void draw(const PlacedTriangle& placed, const FilmBox& box, const Cell& cell);
  void draw_row(const PlacedTriangle& placed, int x_begin, int x_end, int y, const Cell& cell);
  void shade(const MeshInstant& mesh, const Cell& cell, std::size_t begin, std::size_t end,
             std::vector<SampledCell::Surface>& surfaces) const;

  const MeshMath& math_;
  std::vector<PlacedTriangle> placed_;
  std::vector<MeshFragment> fragments_, sorted_;
  std::vector<std::uint32_t> starts_;
};

}  // namespace swept
