// Which moving triangles come by each tile of the film, in which stretches of their paths.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "abuffer/sources/moving_mesh.h"
#include "abuffer/tiles/tile_grid.h"
#include "splat/camera.h"

namespace swept {

/// What holds all that is seen of a triangle over a stretch: the convex hull of these points of the film, px.
/// They are its control points in front of the near plane, and where lines between any two of them meet it.
struct FilmHull {
  int count = 0;  ///< 0: nothing is seen
  double x[48], y[48];
  double x_min, x_max, y_min, y_max;

  /// Where rows from `top` to `bottom` are within it; false: nowhere.
  [[nodiscard]] bool span(double top, double bottom, double& left, double& right) const;
};
[[nodiscard]] FilmHull hull_of(const MovingMesh& mesh, std::size_t stretch, std::size_t triangle,
                               const Projection& projection, double near);

/// What no point of the triangle is nearer than over the stretch, where it is in front of the near plane.
[[nodiscard]] float nearest_of(const MovingMesh& mesh, std::size_t stretch, std::size_t triangle,
                               double near);

class MeshBins {
 public:
  struct Entry {
    std::uint32_t mesh, stretch, triangle;
  };

  /// Tiles of `tile_px` of the film's window. Runs in the caller's task arena.
  MeshBins(const std::vector<MovingMesh>& meshes, const Projection& projection, double near,
           const Window& film, int tile_px, const std::stop_token& stop);

  [[nodiscard]] std::size_t tile_count() const { return tiles_.count(); }
  [[nodiscard]] Window window(std::size_t tile) const { return tiles_.window(tile); }
  /// By mesh, stretch and triangle.
  [[nodiscard]] std::span<const Entry> entries(std::size_t tile) const {
    return std::span(entries_).subspan(starts_[tile], starts_[tile + 1] - starts_[tile]);
  }
  [[nodiscard]] std::size_t entry_count() const { return entries_.size(); }
  [[nodiscard]] std::size_t bytes() const { return entries_.size() * sizeof(Entry); }

 private:
  TileGrid tiles_;
  std::vector<std::size_t> starts_;
  std::vector<Entry> entries_;
};

}  // namespace swept
