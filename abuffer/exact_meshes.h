// Fragments of moving triangles: intervals of time at every place of every pixel. For the project's own
// sources. Source: model section 15.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "abuffer/resolve/mesh_pixel.h"
#include "abuffer/sources/fragment_source.h"
#include "abuffer/tiles/mesh_bins.h"

namespace swept {

/// What all threads share of the meshes of a scene.
struct MeshFilm {
  const Scene& scene;
  Exposure exposure, all;  ///< of the top row, and of all rows
  std::vector<MovingMesh> meshes;
  Projection projection;
  std::optional<MeshBins> bins;
  std::size_t interval_limit;
  std::stop_token stop;

  /// Of the meshes of a scene that has some, which must outlive it. Error: one of them cannot be followed.
  /// Throws Stopped.
  [[nodiscard]] static Result<MeshFilm> follow(const Scene& scene, const Window& window, int tile_px,
                                               std::size_t limit, const std::stop_token& stop);
};

class MeshFragments final : public FragmentSource {
 public:
  /// `film` must outlive it.
  explicit MeshFragments(const MeshFilm& film) : film_(film) {}

  void select(std::size_t tile) override;
  [[nodiscard]] bool gather(const Window& window) override;

  /// The intervals of a pixel, which is counted row by row within the window, by place; at a place in the
  /// order of meshes and their triangles. They may be put into another order.
  [[nodiscard]] std::span<PlaceInterval> of_pixel(std::size_t local) {
    const std::size_t first = starts_[pixel_places * local], last = starts_[pixel_places * (local + 1)];
    return std::span(sorted_).subspan(first, last - first);
  }
  /// What their sources are indices of.
  [[nodiscard]] const std::vector<TriangleStretch>& triangles() const { return triangles_; }
  [[nodiscard]] std::size_t interval_count() const { return sorted_.size(); }
  [[nodiscard]] PlaceRays rays(int x, int y) const;
  /// Of the window's row that begins the `row`-th.
  [[nodiscard]] const LightOverTime& light(int row) const { return rows_[static_cast<std::size_t>(row)]; }

 private:
  [[nodiscard]] Eigen::Vector3d ray(int x, int y, double dx, double dy) const;
  void sort_by_place(const Window& window);

  const MeshFilm& film_;
  std::span<const MeshBins::Entry> entries_;
  std::vector<LightOverTime> rows_;  ///< of the window
  std::vector<TriangleStretch> triangles_;
  std::vector<PlaceInterval> intervals_, sorted_;
  std::vector<std::size_t> starts_, fill_;
};

}  // namespace swept
