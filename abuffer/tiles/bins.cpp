#include "abuffer/tiles/bins.h"

#include <algorithm>
#include <cmath>

#include "splat/without_throwing.h"

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

TileBins::TileBins(const KernelSet& set, const Window& film_window, int tile_px, const std::stop_token& stop)
    : tiles_(film_window, tile_px), starts_(tiles_.count() + 1) {
  const PixelBox film = film_window.centers();
  const auto columns = static_cast<int>(tiles_.columns()), rows = static_cast<int>(tiles_.rows());
  bool back = false;  // why for_each_tile found none
  const auto for_each_tile = [&](const MovingKernel& kernel, auto&& visit) {
    back = false;
    Octagon octagon;
    if (!screen_bounds(kernel, set.projection, set.near, octagon) || !octagon.overlaps(film)) return false;
    const PixelBox box = octagon.box();
    if (faces_away(kernel, box, set.projection)) {
      back = true;
      return false;
    }
    const auto tile_of = [&](double position, int origin, int tiles) {
      return static_cast<int>(std::clamp((position - origin) / tile_px, 0.0, tiles - 1.0));
    };
    const int x0 = tile_of(box.x_min, film_window.x, columns),
              x1 = tile_of(box.x_max, film_window.x, columns);
    const int y0 = tile_of(box.y_min, film_window.y, rows), y1 = tile_of(box.y_max, film_window.y, rows);
    bool any = false;
    for (int ty = y0; ty <= y1; ++ty)
      for (int tx = x0; tx <= x1; ++tx) {
        const std::size_t tile =
            static_cast<std::size_t>(ty) * tiles_.columns() + static_cast<std::size_t>(tx);
        if (!octagon.overlaps(window(tile).centers())) continue;
        any = true;
        visit(tile);
      }
    return any;
  };
  const auto look_at_stop = [&](std::size_t kernel) {
    if (kernel % 1024 == 0) throw_if_stopped(stop);
  };
  for (std::size_t k = 0; k < set.kernels.size(); ++k) {
    look_at_stop(k);
    if (!for_each_tile(set.kernels[k], [&](std::size_t tile) { ++starts_[tile + 1]; }))
      ++(back ? facing_away_ : outside_);
  }
  for (std::size_t tile = 1; tile < starts_.size(); ++tile) starts_[tile] += starts_[tile - 1];
  entries_.resize(starts_.back());
  std::vector<std::size_t> fill(starts_.begin(), starts_.end() - 1);
  for (std::size_t k = 0; k < set.kernels.size(); ++k) {
    look_at_stop(k);
    for_each_tile(set.kernels[k],
                  [&](std::size_t tile) { entries_[fill[tile]++] = static_cast<std::uint32_t>(k); });
  }
}

}  // namespace swept
