#include "abuffer/exact_meshes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "splat/without_throwing.h"

namespace swept {

Result<MeshFilm> MeshFilm::follow(const Scene& scene, const Window& window, const AbufferOptions& options,
                                  const std::stop_token& stop) {
  const Exposure exposure = scene.exposure();
  MeshFilm film{scene,
                exposure,
                exposure.of_all_rows(scene.film.height),
                {},
                {},
                {},
                options.tile_fragments,
                options.place_intervals,
                options.tile_tests,
                options.back_faces,
                stop};
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
  film.bins.emplace(film.meshes, film.projection, scene.camera.near, window, options.tile_px,
                    options.back_faces, stop);
  throw_if_stopped(stop);
  return film;
}

std::size_t bytes_of(const MeshFilm& film) {
  std::size_t bytes = film.bins->bytes();
  for (const MovingMesh& mesh : film.meshes) bytes += mesh.bytes();
  return bytes;
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

void MeshFragments::select(std::size_t tile) {
  entries_ = film_.bins->entries(tile);
  order_entries();
}

/// From the nearest on, so that what hides comes before what it hides.
void MeshFragments::order_entries() {
  order_.clear();
  std::size_t looks = 0;
  const auto look_at_stop = [&] {
    if (++looks % 4096 == 0) throw_if_stopped(film_.stop);
  };
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    look_at_stop();
    order_.push_back({film_.tile_tests ? nearest_of(film_.meshes[entries_[i].mesh], entries_[i].stretch,
                                                    entries_[i].triangle, film_.scene.camera.near)
                                       : 0.0f,
                      static_cast<std::uint32_t>(i)});
  }
  const auto path = [&](std::uint32_t i, std::size_t corner) -> const Eigen::Vector3d& {
    const MovingMesh& mesh = film_.meshes[entries_[i].mesh];
    return *mesh.path(entries_[i].stretch, mesh.object().triangles[entries_[i].triangle][corner]);
  };
  std::sort(order_.begin(), order_.end(), [&](const auto& a, const auto& b) {
    look_at_stop();
    if (a.first != b.first || !film_.tile_tests) return a < b;
    // Equally near: by what they are, as the order of meshes must not matter.
    for (std::size_t corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis) {
        const double of_a = path(a.second, corner)[axis], of_b = path(b.second, corner)[axis];
        if (of_a != of_b) return of_a < of_b;
      }
    return a.second < b.second;
  });
}

bool MeshFragments::gather(const Window& window) {
  intervals_.clear();
  triangles_.clear();
  entry_of_.clear();
  std::size_t merged = 0, looked_at = 0;
  all_clear_ = true;
  shorten_at_ = lossy_.most() > 0 ? 4096 : std::numeric_limits<std::size_t>::max();
  set_rays(window);
  rows_.clear();
  for (int y = window.y; y < window.y + window.height; ++y)
    rows_.emplace_back(film_.all, film_.exposure.of_row(y));
  cover_.start(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height));
  for (const auto& [nearest, index] : order_) {
    if (cover_.hides_tile(nearest)) break;
    ++looked_at;
    if (!gather_entry(window, entries_[index], nearest) || forecast_is_too_many(window, looked_at)) {
      forecast_halvings(looked_at);
      return false;
    }
    if (film_.stop.stop_requested()) return true;
    if (triangles_.size() > entry_of_.size()) entry_of_.push_back(index);
    if (intervals_.size() <= shorten_at_) continue;
    merged += intervals_.size();
    shorten(window);
    merged -= intervals_.size();
  }
  most_held_ = std::max(most_held_, intervals_.size());
  met_ = intervals_.size() + merged;
  restore_order();
  sort_by_place(window);
  if (lossy_.most() > 0) merge_places();
  return true;
}

/// How many times what may be held all triangles have, if they have as many intervals as those looked at; 0
/// where that cannot be told. What is clear hides none of those to come.
double MeshFragments::forecast(std::size_t looked_at) const {
  if (!all_clear_ || lossy_.most() > 0) return 0.0;
  return static_cast<double>(intervals_.size()) * static_cast<double>(order_.size()) /
         (static_cast<double>(film_.interval_limit) * static_cast<double>(looked_at));
}

/// Whether that is plain from an eighth of the triangles on.
bool MeshFragments::forecast_is_too_many(const Window& window, std::size_t looked_at) const {
  return window.width * window.height > 1 && 8 * looked_at >= order_.size() && forecast(looked_at) > 2.0;
}

void MeshFragments::forecast_halvings(std::size_t looked_at) {
  halvings_ = 1;
  // Halves are not quite alike.
  for (double parts = 1.1 * forecast(looked_at); parts > 2.0 && halvings_ < 30; parts *= 0.5) ++halvings_;
}

void MeshFragments::set_rays(const Window& window) {
  ray_x_.clear();
  ray_y_.clear();
  for (int x = window.x; x < window.x + window.width; ++x)
    for (const Eigen::Vector3d& of : rays(x, window.y)) ray_x_.push_back(of.x());
  for (int y = window.y; y < window.y + window.height; ++y)
    for (const Eigen::Vector3d& of : rays(window.x, y)) ray_y_.push_back(of.y());
}

/// False: more intervals than one thread may hold, of more than a pixel.
bool MeshFragments::gather_entry(const Window& window, const MeshBins::Entry& entry, float nearest) {
  const FilmHull hull = hull_of(film_.meshes[entry.mesh], entry.stretch, entry.triangle, film_.projection,
                                film_.scene.camera.near);
  if (hull.count == 0) return true;
  std::optional<TriangleStretch> triangle;
  const auto pixel = [](double at, int begin, int end) {
    return static_cast<int>(std::clamp<double>(std::floor(at), begin, end));
  };
  const int top = pixel(hull.y_min - 1.0, window.y, window.y + window.height),
            bottom = pixel(hull.y_max + 2.0, window.y, window.y + window.height);
  const double half = 0.5 / film_.projection.focal_px;
  const std::size_t before = intervals_.size();
  for (int y = top; y < bottom; ++y) {
    double left = hull.x_min, right = hull.x_max;
    if (film_.tile_tests && !hull.span(y - 1e-3, y + 1.0 + 1e-3, left, right)) continue;
    const int first = pixel(left - 1e-3, window.x, window.x + window.width),
              last = pixel(right + 1.0 + 1e-3, window.x, window.x + window.width);
    if (first >= last) continue;
    if (film_.stop.stop_requested()) return true;
    if (!triangle) {
      triangle.emplace(film_.meshes[entry.mesh], entry.mesh, entry.stretch, entry.triangle,
                       film_.scene.camera.near, film_.projection.orthographic);
      blocks_.start(window, film_.tile_tests && (hull.x_max - hull.x_min) * (bottom - top) > 256.0);
    }
    const LightOverTime& light = rows_[static_cast<std::size_t>(y - window.y)];
    for (int x = first; x < last; ++x) {
      const auto at = static_cast<std::uint32_t>((y - window.y) * window.width + (x - window.x));
      if (film_.tile_tests) {
        if (cover_.hides_pixel(at, nearest)) continue;
        if (blocks_.misses(x, y, [&](double middle_x, double middle_y, double half_px) {
              return triangle->misses(ray(0, 0, middle_x - 0.5, middle_y - 0.5),
                                      half_px / film_.projection.focal_px,
                                      half_px / film_.projection.focal_px);
            }))
          continue;
        if (triangle->misses(ray(x, y, 0.0, 0.0), half, half)) continue;
      }
      const RaysOfPixel rays{&ray_x_[static_cast<std::size_t>(x - window.x) * pixel_places],
                             &ray_y_[static_cast<std::size_t>(y - window.y) * pixel_places]};
      meet_pixel(*triangle, rays, light, at * pixel_places, nearest);
    }
    if (window.width * window.height > 1 && intervals_.size() > film_.interval_limit) return false;
  }
  if (intervals_.size() == before) return true;
  triangles_.push_back(*triangle);
  all_clear_ = all_clear_ && !triangle->opaque;
  return true;
}

void MeshFragments::meet_pixel(const TriangleStretch& triangle, const RaysOfPixel& rays,
                               const LightOverTime& light, std::uint32_t place, float nearest) {
  MetPlaces met;
  met.above = met.below = 0;
  if (triangle.straight())
    edge_math_.meet(triangle.straight_edges(), rays.x, rays.y, met);
  else
    met.unknown = triangle.may_meet(rays);
  const auto source = static_cast<std::uint32_t>(triangles_.size());
  for (std::uint32_t places = met.above | met.below | met.unknown; places != 0; places &= places - 1) {
    const auto k = static_cast<std::uint32_t>(std::countr_zero(places));
    if (film_.tile_tests && cover_.hides_place(triangle.mesh, place + k, nearest)) continue;
    const std::size_t before = intervals_.size();
    if ((met.unknown >> k & 1) != 0)
      triangle.meet(rays[k], light.from(), light.to(), place + k, source, intervals_);
    else
      triangle.keep(rays[k], light.from(), light.to(), met, k, place + k, source, intervals_);
    if (!triangle.opaque) continue;
    for (std::size_t i = before; i < intervals_.size(); ++i)
      cover_.add(triangle.mesh, place + k, intervals_[i].begin, intervals_[i].end, intervals_[i].farthest,
                 light.from(), light.to());
  }
}

/// Numbers triangles as the mesh has them, which tells those at equal depths apart.
void MeshFragments::restore_order() {
  std::vector<std::uint32_t>& by_entry = rank_;
  by_entry.resize(triangles_.size());
  for (std::size_t t = 0; t < by_entry.size(); ++t) by_entry[t] = static_cast<std::uint32_t>(t);
  std::sort(by_entry.begin(), by_entry.end(),
            [&](std::uint32_t a, std::uint32_t b) { return entry_of_[a] < entry_of_[b]; });
  reordered_.clear();
  for (const std::uint32_t t : by_entry) reordered_.push_back(triangles_[t]);
  triangles_.swap(reordered_);
  std::vector<std::uint32_t>& to = entry_of_;
  for (std::size_t t = 0; t < by_entry.size(); ++t) to[by_entry[t]] = static_cast<std::uint32_t>(t);
  for (PlaceInterval& i : intervals_) i.source = to[i.source];
}

/// Merges what places have too many of, and puts the intervals in the order of places.
void MeshFragments::shorten(const Window& window) {
  most_held_ = std::max(most_held_, intervals_.size());
  sort_by_place(window);
  intervals_.clear();
  for (std::size_t p = 0; p + 1 < starts_.size(); ++p) {
    const std::span<PlaceInterval> of_place(sorted_.data() + starts_[p], starts_[p + 1] - starts_[p]);
    const std::size_t left = lossy_.shorten(of_place, triangles_);
    intervals_.insert(intervals_.end(), of_place.begin(),
                      of_place.begin() + static_cast<std::ptrdiff_t>(left));
  }
  shorten_at_ = std::max<std::size_t>(4096, 2 * intervals_.size());
}

/// A stable counting sort.
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

/// Leaves as many intervals at each place as are asked for.
void MeshFragments::merge_places() {
  std::size_t to = 0;
  for (std::size_t p = 0; p + 1 < starts_.size(); ++p) {
    const std::span<PlaceInterval> of_place(sorted_.data() + starts_[p], starts_[p + 1] - starts_[p]);
    const std::size_t left = lossy_.finish(of_place, triangles_);
    std::copy_n(of_place.begin(), left, sorted_.begin() + static_cast<std::ptrdiff_t>(to));
    starts_[p] = to;
    to += left;
  }
  starts_.back() = to;
  sorted_.resize(to);
}

}  // namespace swept
