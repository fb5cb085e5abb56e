#include "abuffer/exact_meshes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "splat/without_throwing.h"

namespace swept {

Result<MeshFilm> MeshFilm::follow(const Scene& scene, const Window& window, int tile_px, std::size_t limit,
                                  const std::stop_token& stop) {
  const Exposure exposure = scene.exposure();
  MeshFilm film{scene, exposure, exposure.of_all_rows(scene.film.height), {}, {}, {}, limit, stop};
  film.projection = projection_of(scene.film, scene.camera.at(film.all.middle()));
  // A tenth of what chords may be off by: parabolas are that much better, and edges show it.
  const double tolerance_px = scene.motion.tolerance_px > 0.0 ? scene.motion.tolerance_px : 0.01;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].triangles.empty()) continue;
    throw_if_stopped(stop);
    Result<MovingMesh> mesh = MovingMesh::follow(scene, scene.objects[i], film.all, tolerance_px, stop);
    if (!mesh) {
      Error error = mesh.error();
      error.field = "/objects/" + std::to_string(i);
      return error;
    }
    film.meshes.push_back(std::move(*mesh));
  }
  film.bins.emplace(film.meshes, film.projection, scene.camera.near, window, tile_px, stop);
  throw_if_stopped(stop);
  return film;
}

Eigen::Vector3d MeshFragments::ray(int x, int y, double dx, double dy) const {
  const Projection& p = film_.projection;
  return {(x + 0.5 + dx - p.center_x) / p.focal_px, (y + 0.5 + dy - p.center_y) / p.focal_px, 1.0};
}

PlaceRays MeshFragments::rays(int x, int y) const {
  PlaceRays result;
  for (std::size_t k = 0; k < pixel_places; ++k)
    result[k] = ray(x, y, double{places_in_pixel.x[k]}, double{places_in_pixel.y[k]});
  return result;
}

void MeshFragments::select(std::size_t tile) { entries_ = film_.bins->entries(tile); }

bool MeshFragments::gather(const Window& window) {
  intervals_.clear();
  triangles_.clear();
  const bool divisible = window.width * window.height > 1;
  const double half = 0.5 / film_.projection.focal_px;
  rows_.clear();
  for (int y = window.y; y < window.y + window.height; ++y)
    rows_.emplace_back(film_.all, film_.exposure.of_row(y));
  for (const MeshBins::Entry& entry : entries_) {
    const FilmHull hull = hull_of(film_.meshes[entry.mesh], entry.stretch, entry.triangle, film_.projection,
                                  film_.scene.camera.near);
    if (hull.count == 0) continue;
    std::optional<TriangleStretch> triangle;
    const auto pixel = [](double at, int begin, int end) {
      return static_cast<int>(std::clamp<double>(std::floor(at), begin, end));
    };
    const int top = pixel(hull.y_min - 1.0, window.y, window.y + window.height),
              bottom = pixel(hull.y_max + 2.0, window.y, window.y + window.height);
    const std::size_t before = intervals_.size();
    for (int y = top; y < bottom; ++y) {
      double left, right;
      if (!hull.span(y - 1e-3, y + 1.0 + 1e-3, left, right)) continue;
      const int first = pixel(left - 1e-3, window.x, window.x + window.width),
                last = pixel(right + 1.0 + 1e-3, window.x, window.x + window.width);
      if (first >= last) continue;
      if (film_.stop.stop_requested()) return true;
      if (!triangle)
        triangle.emplace(film_.meshes[entry.mesh], entry.mesh, entry.stretch, entry.triangle,
                         film_.scene.camera.near, film_.projection.orthographic);
      const LightOverTime& light = rows_[static_cast<std::size_t>(y - window.y)];
      for (int x = first; x < last; ++x) {
        if (triangle->misses(ray(x, y, 0.0, 0.0), half, half)) continue;
        const auto local =
            static_cast<std::uint32_t>((y - window.y) * window.width + (x - window.x)) * pixel_places;
        for (std::uint32_t k = 0; k < pixel_places; ++k)
          triangle->meet(ray(x, y, double{places_in_pixel.x[k]}, double{places_in_pixel.y[k]}), light.from(),
                         light.to(), local + k, static_cast<std::uint32_t>(triangles_.size()), intervals_);
      }
      if (divisible && intervals_.size() > film_.interval_limit) return false;
    }
    if (intervals_.size() > before) triangles_.push_back(*triangle);
  }
  sort_by_place(window);
  return true;
}

/// A stable counting sort: at a place intervals keep the order of meshes and their triangles.
void MeshFragments::sort_by_place(const Window& window) {
  const std::size_t places =
      static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height) * pixel_places;
  starts_.assign(places + 1, 0);
  for (const PlaceInterval& i : intervals_) ++starts_[i.place + 1];
  for (std::size_t p = 0; p < places; ++p) starts_[p + 1] += starts_[p];
  sorted_.resize(intervals_.size());
  fill_.assign(starts_.begin(), starts_.end() - 1);
  for (const PlaceInterval& i : intervals_) sorted_[fill_[i.place]++] = i;
}

}  // namespace swept
