// Fragments of moving triangles: intervals of time at every place of every pixel. For the project's own
// sources. Source: model section 15.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "abuffer/abuffer.h"
#include "abuffer/resolve/lossy_intervals.h"
#include "abuffer/resolve/mesh_pixel.h"
#include "abuffer/sources/fragment_source.h"
#include "abuffer/tiles/block_tests.h"
#include "abuffer/tiles/mesh_bins.h"
#include "abuffer/tiles/tile_cover.h"

namespace swept {

/// What all threads share of the meshes of a scene.
struct MeshFilm {
  const Scene& scene;
  Exposure exposure, all;  ///< of the top row, and of all rows
  std::vector<MovingMesh> meshes;
  Projection projection;
  std::optional<MeshBins> bins;
  std::size_t interval_limit, place_intervals;
  bool tile_tests;
  BackFaces back_faces;
  std::stop_token stop;

  /// Of the meshes of a scene that has some, which must outlive it. Error: one of them cannot be followed.
  /// Throws Stopped.
  [[nodiscard]] static Result<MeshFilm> follow(const Scene& scene, const Window& window,
                                               const AbufferOptions& options, const std::stop_token& stop);
};

/// What its paths and bins take.
[[nodiscard]] std::size_t bytes_of(const MeshFilm& film);

class MeshFragments final : public FragmentSource {
 public:
  /// `film` must outlive it.
  explicit MeshFragments(const MeshFilm& film) : film_(film), lossy_(film.place_intervals) {}

  void select(std::size_t tile) override;
  [[nodiscard]] bool gather(const Window& window) override;

  /// After gather() has found more than may be held: how often to halve the window, as far as can be told
  /// from what it has looked at.
  [[nodiscard]] int halvings() const { return halvings_; }

  /// The intervals of a pixel, which is counted row by row within the window, by place. They may be put into
  /// another order.
  [[nodiscard]] std::span<PlaceInterval> of_pixel(std::size_t local) {
    return between(pixel_places * local, pixel_places * (local + 1));
  }
  [[nodiscard]] std::span<PlaceInterval> of_place(std::size_t local, std::size_t place) {
    return between(pixel_places * local + place, pixel_places * local + place + 1);
  }
  /// What their sources are indices of.
  [[nodiscard]] const std::vector<TriangleStretch>& triangles() const { return triangles_; }
  /// Of the window; those that were merged are counted, too.
  [[nodiscard]] std::size_t interval_count() const { return met_; }
  /// The most that were held at once.
  [[nodiscard]] std::size_t most_held() const { return most_held_; }
  [[nodiscard]] PlaceRays rays(int x, int y) const;
  /// Of the window's row that begins the `row`-th.
  [[nodiscard]] const LightOverTime& light(int row) const { return rows_[static_cast<std::size_t>(row)]; }

 private:
  [[nodiscard]] std::span<PlaceInterval> between(std::size_t first, std::size_t last) {
    return std::span(sorted_).subspan(starts_[first], starts_[last] - starts_[first]);
  }
  [[nodiscard]] Eigen::Vector3d ray(int x, int y, double dx, double dy) const;
  void order_entries();
  [[nodiscard]] bool gather_entry(const Window& window, const MeshBins::Entry& entry, float nearest);
  [[nodiscard]] double forecast(std::size_t looked_at) const;
  [[nodiscard]] bool forecast_is_too_many(const Window& window, std::size_t looked_at) const;
  void forecast_halvings(std::size_t looked_at);
  void set_rays(const Window& window);
  void meet_pixel(const TriangleStretch& triangle, const RaysOfPixel& rays, const LightOverTime& light,
                  std::uint32_t place, float nearest);
  void restore_order();
  void shorten(const Window& window);
  void sort_by_place(const Window& window);
  void merge_places();

  const MeshFilm& film_;
  const EdgeMath& edge_math_ = edge_maths().fastest();
  LossyIntervals lossy_;
  TileCover cover_;
  BlockTests blocks_;
  std::span<const MeshBins::Entry> entries_;
  std::vector<std::pair<float, std::uint32_t>> order_;  ///< entries by their nearest depth
  std::vector<std::uint32_t> entry_of_, rank_;          ///< of triangles_
  std::vector<LightOverTime> rows_;                     ///< of the window
  std::vector<double> ray_x_, ray_y_;                   ///< of its columns and rows, place by place
  std::vector<TriangleStretch> triangles_, reordered_;
  std::vector<PlaceInterval> intervals_, sorted_;
  std::vector<std::size_t> starts_, fill_;
  bool all_clear_ = true;  ///< none that has intervals is opaque
  int halvings_ = 1;
  std::size_t met_ = 0, most_held_ = 0, shorten_at_ = 0;
};

}  // namespace swept
