#include "abuffer/tiles/mesh_bins.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "abuffer/parallel.h"
#include "abuffer/tiles/mesh_facing.h"

namespace swept {

bool FilmHull::span(double top, double bottom, double& left, double& right) const {
  left = std::numeric_limits<double>::infinity();
  right = -left;
  const auto take = [&](double at) { left = std::min(left, at), right = std::max(right, at); };
  for (int i = 0; i < count; ++i) {
    if (y[i] >= top && y[i] <= bottom) take(x[i]);
    for (int j = 0; j < i; ++j)
      for (const double row : {top, bottom})
        if ((y[i] < row) != (y[j] < row)) take(x[i] + (row - y[i]) / (y[j] - y[i]) * (x[j] - x[i]));
  }
  return left <= right;
}

FilmHull hull_of(const MovingMesh& mesh, std::size_t stretch, std::size_t triangle,
                 const Projection& projection, double near) {
  FilmHull hull;
  const Eigen::Vector3d* points[3 * (most_path_degree + 1)];
  int count = 0;
  for (const std::uint32_t corner : mesh.object().triangles[triangle])
    for (int k = 0; k <= mesh.degree(); ++k) points[count++] = mesh.path(stretch, corner) + k;
  hull.x_min = hull.y_min = std::numeric_limits<double>::infinity();
  hull.x_max = hull.y_max = -hull.x_min;
  const auto add = [&](const Eigen::Vector3d& p, double z) {
    const int i = hull.count++;
    hull.x[i] = projection.center_x + projection.focal_px * (p.x() / z);
    hull.y[i] = projection.center_y + projection.focal_px * (p.y() / z);
    hull.x_min = std::min(hull.x_min, hull.x[i]), hull.x_max = std::max(hull.x_max, hull.x[i]);
    hull.y_min = std::min(hull.y_min, hull.y[i]), hull.y_max = std::max(hull.y_max, hull.y[i]);
  };
  if (projection.orthographic) {
    const bool seen =
        std::any_of(points, points + count, [&](const Eigen::Vector3d* p) { return p->z() >= near; });
    for (int i = 0; seen && i < count; ++i) add(*points[i], 1.0);
    return hull;
  }
  for (int i = 0; i < count; ++i)
    if (points[i]->z() >= near) add(*points[i], points[i]->z());
  // At most 6 · 6 of 12 points are on either side: 36 and 12.
  if (hull.count > 0 && hull.count < count)
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j) {
        const Eigen::Vector3d &a = *points[i], &b = *points[j];
        if (a.z() >= near && b.z() < near) add(a + (near - a.z()) / (b.z() - a.z()) * (b - a), near);
      }
  return hull;
}

float nearest_of(const MovingMesh& mesh, std::size_t stretch, std::size_t triangle, double near) {
  double z = std::numeric_limits<double>::infinity();
  for (const std::uint32_t corner : mesh.object().triangles[triangle])
    for (int k = 0; k <= mesh.degree(); ++k) z = std::min(z, mesh.path(stretch, corner)[k].z());
  // Below what rounding to a float, or any of its depths, may be.
  return static_cast<float>(std::max(z, near) * (1.0 - 1e-6));
}

namespace {

/// Whether a triangle is left out, and why.
enum class Away : char { no, always, at_both_ends };

Away away_of(const MovingMesh& mesh, const MeshBins::Entry& entry, BackFaces back_faces, bool orthographic) {
  if (mesh.object().two_sided) return Away::no;
  if (always_faces_away(mesh, entry.stretch, entry.triangle, orthographic)) return Away::always;
  const bool both_ends =
      back_faces == BackFaces::both_ends && faces_away_at_both_ends(mesh, entry.triangle, orthographic);
  return both_ends ? Away::at_both_ends : Away::no;
}

}  // namespace

MeshBins::MeshBins(const std::vector<MovingMesh>& meshes, const Projection& projection, double near,
                   const Window& film, int tile_px, BackFaces back_faces, const std::stop_token& stop)
    : tiles_(film, tile_px) {
  const std::size_t columns = tiles_.columns(), rows = tiles_.rows();
  struct Tiles {
    std::uint32_t x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;
  };
  std::vector<Entry> all;
  for (std::size_t m = 0; m < meshes.size(); ++m)
    for (std::size_t s = 0; s < meshes[m].stretches(); ++s)
      for (std::size_t t = 0; t < meshes[m].object().triangles.size(); ++t)
        all.push_back(
            {static_cast<std::uint32_t>(m), static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(t)});
  std::vector<Tiles> touched(all.size());
  std::vector<Away> away(all.size(), Away::no);
  parallel_for_each_index(all.size(), [&](std::size_t i) {
    away[i] = away_of(meshes[all[i].mesh], all[i], back_faces, projection.orthographic);
    if (away[i] != Away::no) return;
    const FilmHull hull = hull_of(meshes[all[i].mesh], all[i].stretch, all[i].triangle, projection, near);
    // Places lie up to half a pixel from the centre; the rest takes care of rounding.
    constexpr double margin = 1.0;
    if (hull.count == 0 || !(hull.x_max + margin > film.x && hull.x_min - margin < film.x + film.width &&
                             hull.y_max + margin > film.y && hull.y_min - margin < film.y + film.height))
      return;
    const auto tile = [&](double px, int first, std::size_t count) {
      const double at = std::clamp(px - first, 0.0, 1e9) / tile_px;
      return static_cast<std::uint32_t>(std::min(static_cast<std::size_t>(at), count - 1));
    };
    touched[i] = {tile(hull.x_min - margin, film.x, columns), tile(hull.x_max + margin, film.x, columns) + 1,
                  tile(hull.y_min - margin, film.y, rows), tile(hull.y_max + margin, film.y, rows) + 1};
  });
  const auto for_each_tile = [&](const Tiles& range, const auto& visit) {
    for (std::size_t y = range.y_begin; y < range.y_end; ++y)
      for (std::size_t x = range.x_begin; x < range.x_end; ++x) visit(y * columns + x);
  };
  facing_away_ = static_cast<std::size_t>(std::count(away.begin(), away.end(), Away::always));
  away_at_both_ends_ = static_cast<std::size_t>(std::count(away.begin(), away.end(), Away::at_both_ends));
  starts_.assign(tile_count() + 1, 0);
  for (const Tiles& range : touched) for_each_tile(range, [&](std::size_t tile) { ++starts_[tile + 1]; });
  for (std::size_t tile = 0; tile < tile_count(); ++tile) starts_[tile + 1] += starts_[tile];
  if (stop.stop_requested()) return;
  entries_.resize(starts_.back());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < all.size(); ++i)
    for_each_tile(touched[i], [&](std::size_t tile) { entries_[next[tile]++] = all[i]; });
}

}  // namespace swept
