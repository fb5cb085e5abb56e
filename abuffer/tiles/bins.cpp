#include "abuffer/tiles/bins.h"

#include <algorithm>
#include <cmath>

namespace swept {
namespace {

/// Whether a one-sided kernel turns its back on every pixel of the box: facing·d is linear over the film, so
/// its corners tell. What rounding leaves open counts as seen.
bool faces_away(const MovingKernel& kernel, const PixelBox& box, const Projection& projection) {
  const Eigen::Vector3d facing = kernel.facing.cast<double>();
  if (facing.isZero(0.0)) return false;
  if (projection.orthographic) return facing.z() >= 0.0;
  const auto least = [&](double slope, double low, double high, double center) {
    return slope * ((slope > 0.0 ? low : high) - center) / projection.focal_px;
  };
  const double x = least(facing.x(), box.x_min, box.x_max, projection.center_x);
  const double y = least(facing.y(), box.y_min, box.y_max, projection.center_y);
  constexpr double rounding = 1e-12;
  return x + y + facing.z() > rounding * (std::abs(x) + std::abs(y) + std::abs(facing.z()));
}

}  // namespace

TileBins::TileBins(const Window& film_window, int tile_px, const Projection& projection, double near)
    : tiles_(film_window, tile_px),
      film_(film_window),
      tile_px_(tile_px),
      projection_(projection),
      near_(near),
      last_(tiles_.count()) {}

void TileBins::put(std::size_t tile, const KernelSource& source) {
  Last& last = last_[tile];
  if (last.count == per_block) {
    blocks_.push_back({{}, last.block});
    last.block = static_cast<std::uint32_t>(blocks_.size() - 1);
    last.count = 0;
  }
  blocks_[last.block].sources[last.count++] = source;
  ++entries_;
}

void TileBins::add(const KernelSource& source, const MovingKernel& kernel, const DiscTurn* turn) {
  Octagon octagon;
  if (!bounds_of(kernel, turn, projection_, near_, octagon) || !octagon.overlaps(film_.centers())) {
    ++outside_;
    return;
  }
  const PixelBox box = octagon.box();
  if (faces_away(kernel, box, projection_)) {
    ++facing_away_;
    return;
  }
  const auto columns = static_cast<int>(tiles_.columns()), rows = static_cast<int>(tiles_.rows());
  const auto tile_of = [&](double position, int origin, int tiles) {
    return static_cast<int>(std::clamp((position - origin) / tile_px_, 0.0, tiles - 1.0));
  };
  const int x0 = tile_of(box.x_min, film_.x, columns), x1 = tile_of(box.x_max, film_.x, columns);
  const int y0 = tile_of(box.y_min, film_.y, rows), y1 = tile_of(box.y_max, film_.y, rows);
  const std::size_t before = entries_;
  const bool moves = turn != nullptr || !kernel.stays();
  for (int ty = y0; ty <= y1; ++ty)
    for (int tx = x0; tx <= x1; ++tx) {
      const std::size_t tile = static_cast<std::size_t>(ty) * tiles_.columns() + static_cast<std::size_t>(tx);
      if (!octagon.overlaps(tiles_.window(tile).centers())) continue;
      put(tile, source);
      last_[tile].moves |= moves;
    }
  if (entries_ == before) ++outside_;
}

}  // namespace swept
