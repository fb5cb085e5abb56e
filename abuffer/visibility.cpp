#include "abuffer/visibility.h"

#include <cassert>
#include <string>
#include <utility>

#include <tbb/blocked_range.h>

#include "abuffer/exact_meshes.h"
#include "abuffer/parallel.h"
#include "abuffer/reference/visible_at.h"
#include "abuffer/render_valid.h"
#include "abuffer/tiles/tile_grid.h"

namespace swept {
namespace {

Status check(const Scene& scene, const std::vector<double>& times) {
  if (Status status = refuse_splats(scene, "visibility accuracy"); !status) return status;
  if (Status status = refuse_row_delay(scene, "visibility accuracy"); !status) return status;
  if (scene.camera.aperture.radius > 0.0)
    return Error{"", "/camera/aperture", "has a radius, and visibility accuracy is of a pinhole",
                 ErrorKind::unsupported};
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (scene.objects[i].triangles.empty())
      return Error{"", "/objects/" + std::to_string(i),
                   "has no triangles, which is what visibility accuracy is about", ErrorKind::unsupported};
  if (scene.film.has_overscan())
    return Error{"", "/film", "has overscan, which visibility accuracy leaves out", ErrorKind::unsupported};
  for (std::size_t i = 0; i < times.size(); ++i)
    if (!(times[i] >= 0.0 && times[i] < 1.0 && (i == 0 || times[i] > times[i - 1])))
      return Error{"", "times", "must be in [0, 1), and rise"};
  return Done{};
}

/// One thread's tiles of it.
class VisibleTiles {
 public:
  VisibleTiles(const MeshFilm& film, const std::vector<std::uint32_t>& first_triangle, const Window& window,
               const std::vector<double>& times, VisibleTriangles& visible)
      : film_(film),
        first_triangle_(first_triangle),
        window_(window),
        times_(times),
        visible_(visible),
        fragments_(film) {}

  void see(std::size_t tile, const Window& window) {
    fragments_.select(tile);
    see_part(window);
  }

 private:
  void see_part(const Window& window) {
    if (film_.stop.stop_requested()) return;
    if (!fragments_.gather(window)) {
      const auto [first, second] = window.halves();
      see_part(first);
      see_part(second);
      return;
    }
    std::size_t local = 0;
    for (int y = window.y; y < window.y + window.height; ++y)
      for (int x = window.x; x < window.x + window.width; ++x, ++local) {
        if (film_.stop.stop_requested()) return;
        see_pixel(x, y, local);
      }
  }

  /// Names what is nearest at each of the times, of all meshes.
  void see_pixel(int x, int y, std::size_t local) {
    const PlaceRays rays = fragments_.rays(x, y);
    std::size_t to = (static_cast<std::size_t>(y - window_.y) * static_cast<std::size_t>(window_.width) +
                      static_cast<std::size_t>(x - window_.x)) *
                     pixel_places * times_.size();
    for (std::size_t k = 0; k < pixel_places; ++k) {
      view_.clear();
      sweep_.cut(fragments_.of_place(local, k), fragments_.triangles(), rays[k], view_);
      const std::vector<PlacePiece>& pieces = view_.pieces;
      std::size_t piece = 0;
      for (const double time : times_) {
        while (piece < pieces.size() && pieces[piece].end <= time) ++piece;
        if (piece < pieces.size() && pieces[piece].begin <= time) {
          const PlaceLayer& nearest = view_.layers[view_.seen[pieces[piece].first]];
          const TriangleStretch& seen = fragments_.triangles()[nearest.source];
          visible_.triangle[to] = first_triangle_[seen.mesh] + seen.triangle;
        }
        ++to;
      }
    }
  }

  const MeshFilm& film_;
  const std::vector<std::uint32_t>& first_triangle_;
  Window window_;
  const std::vector<double>& times_;
  VisibleTriangles& visible_;
  MeshFragments fragments_;
  PlaceSweep sweep_;
  PlaceView view_;
};

VisibleTriangles blank(const Window& window, std::size_t times) {
  VisibleTriangles visible{window.width, window.height, times, {}};
  visible.triangle.assign(
      static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height) * pixel_places * times,
      no_triangle);
  return visible;
}

}  // namespace

Result<VisibleTriangles> visible_by_intervals(const Scene& scene, const std::vector<double>& times,
                                              const AbufferOptions& options, const RenderControl& control) {
  if (Status status = check(scene, times); !status) return status.error();
  if (Status status = options.validate(); !status) return status.error();
  if (Status status = control.validate(); !status) return status.error();
  if (Status status = scene.validate(); !status) return status.error();
  return run_in_arena(control, [&]() -> Result<VisibleTriangles> {
    const Window window{scene.film.crop_x, scene.film.crop_y, scene.film.window_width(),
                        scene.film.window_height()};
    const Result<MeshFilm> film = MeshFilm::follow(scene, window, options, control.stop);
    if (!film) return film.error();
    std::vector<std::uint32_t> first_triangle;
    std::size_t triangles = 0;
    for (const MovingMesh& mesh : film->meshes) {
      first_triangle.push_back(static_cast<std::uint32_t>(triangles));
      triangles += mesh.object().triangles.size();
    }
    VisibleTriangles visible = blank(window, times.size());
    PerThread<VisibleTiles> threads(
        [&] { return VisibleTiles(*film, first_triangle, window, times, visible); });
    const TileGrid tiles(window, options.tile_px);
    parallel_for_parts(tbb::blocked_range<std::size_t>(0, tiles.count(), 1), [&](const auto& range) {
      VisibleTiles& thread = threads.local();
      for (std::size_t tile = range.begin(); tile != range.end(); ++tile)
        thread.see(tile, tiles.window(tile));
    });
    throw_if_stopped(control.stop);
    return visible;
  });
}

Result<VisibleTriangles> visible_at_instants(const Scene& scene, const std::vector<double>& times,
                                             const RenderControl& control) {
  if (Status status = check(scene, times); !status) return status.error();
  if (Status status = control.validate(); !status) return status.error();
  if (Status status = scene.validate(); !status) return status.error();
  return run_in_arena(control,
                      [&]() -> Result<VisibleTriangles> { return reference::triangles_at(scene, times); });
}

VisibilityAccuracy visibility_accuracy(const VisibleTriangles& a, const VisibleTriangles& b) {
  assert(a.triangle.size() == b.triangle.size());
  VisibilityAccuracy of;
  for (std::size_t i = 0; i < a.triangle.size(); ++i) {
    if (a.triangle[i] == no_triangle && b.triangle[i] == no_triangle) continue;
    ++of.samples;
    of.same += a.triangle[i] == b.triangle[i] ? 1 : 0;
  }
  return of;
}

}  // namespace swept
