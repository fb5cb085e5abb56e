#include "abuffer/exact_meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <tbb/blocked_range.h>

#include "abuffer/parallel.h"
#include "abuffer/progress_of.h"
#include "abuffer/resolve/lossy_intervals.h"
#include "abuffer/resolve/mesh_pixel.h"
#include "abuffer/resolve/place_light.h"
#include "abuffer/tiles/block_tests.h"
#include "abuffer/tiles/mesh_bins.h"
#include "abuffer/tiles/tile_cover.h"
#include "splat/motion/instant.h"
#include "splat/stopwatch.h"

namespace swept {
namespace {

/// What all tiles share.
struct MeshFilm {
  const Scene& scene;
  Exposure exposure, all;  ///< of the top row, and of all rows
  std::vector<MovingMesh> meshes;
  Projection projection;
  std::size_t interval_limit, place_intervals;
  bool tile_tests;
  std::stop_token stop;
  MeshProbe* probe;                           ///< may be null
  std::vector<std::uint32_t> first_triangle;  ///< of each mesh, counted over all
};

struct Counters {
  std::uint64_t intervals = 0, held = 0, most_intervals = 0, split_tiles = 0, pixels = 0, mixed_pixels = 0;
  PlaceCounters sweep;
};

/// One thread's tile: intervals of a window, then pixel by pixel. Its memory is kept from tile to tile.
class MeshTile {
 public:
  MeshTile(const MeshFilm& film, Image& image) : film_(film), image_(image), lossy_(film.place_intervals) {}

  /// Halves the window until its intervals fit; a single pixel always does.
  void render(const Window& window, std::span<const MeshBins::Entry> entries) {
    if (film_.stop.stop_requested()) return;
    if (!gather(window, entries)) {
      ++counters.split_tiles;
      const auto [first, second] = window.halves();
      render(first, entries);
      render(second, entries);
      return;
    }
    resolve(window);
  }

  Counters counters;
  [[nodiscard]] const PlaceCounters& sweep_counters() const { return sweep_.counters; }

 private:
  [[nodiscard]] Eigen::Vector3d ray(int x, int y, double dx, double dy) const {
    const Projection& p = film_.projection;
    return {(x + 0.5 + dx - p.center_x) / p.focal_px, (y + 0.5 + dy - p.center_y) / p.focal_px, 1.0};
  }
  [[nodiscard]] PlaceRays rays(int x, int y) const {
    PlaceRays result;
    for (std::size_t k = 0; k < pixel_places; ++k)
      result[k] = ray(x, y, double{places_in_pixel.x[k]}, double{places_in_pixel.y[k]});
    return result;
  }

  /// From the nearest on, so that what hides comes before what it hides.
  void order_entries(std::span<const MeshBins::Entry> entries) {
    order_.clear();
    for (std::size_t i = 0; i < entries.size(); ++i)
      order_.push_back({film_.tile_tests ? nearest_of(film_.meshes[entries[i].mesh], entries[i].stretch,
                                                      entries[i].triangle, film_.scene.camera.near)
                                         : 0.0f,
                        static_cast<std::uint32_t>(i)});
    const auto path = [&](std::uint32_t i, std::size_t corner) -> const Eigen::Vector3d& {
      const MovingMesh& mesh = film_.meshes[entries[i].mesh];
      return *mesh.path(entries[i].stretch, mesh.object().triangles[entries[i].triangle][corner]);
    };
    std::sort(order_.begin(), order_.end(), [&](const auto& a, const auto& b) {
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

  bool gather(const Window& window, std::span<const MeshBins::Entry> entries) {
    intervals_.clear();
    triangles_.clear();
    entry_of_.clear();
    merged_ = 0;
    shorten_at_ = lossy_.most() > 0 ? 4096 : std::numeric_limits<std::size_t>::max();
    rows_.clear();
    for (int y = window.y; y < window.y + window.height; ++y)
      rows_.emplace_back(film_.all, film_.exposure.of_row(y));
    cover_.start(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height));
    order_entries(entries);
    for (const auto& [nearest, index] : order_) {
      if (cover_.hides_tile(nearest)) break;
      if (!gather_entry(window, entries[index], nearest)) return false;
      if (film_.stop.stop_requested()) return true;
      if (triangles_.size() > entry_of_.size()) entry_of_.push_back(index);
      if (intervals_.size() <= shorten_at_) continue;
      merged_ += intervals_.size();
      shorten(window);
      merged_ -= intervals_.size();
    }
    counters.held = std::max<std::uint64_t>(counters.held, intervals_.size());
    counters.intervals += intervals_.size() + merged_;
    restore_order();
    return true;
  }

  /// False: more intervals than one thread may hold, of more than a pixel.
  bool gather_entry(const Window& window, const MeshBins::Entry& entry, float nearest) {
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
                         film_.scene.camera.near);
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
        meet_pixel(*triangle, x, y, light, at * pixel_places, nearest);
      }
      if (window.width * window.height > 1 && intervals_.size() > film_.interval_limit) return false;
    }
    if (intervals_.size() > before) triangles_.push_back(*triangle);
    return true;
  }

  void meet_pixel(const TriangleStretch& triangle, int x, int y, const LightOverTime& light,
                  std::uint32_t place, float nearest) {
    for (std::uint32_t k = 0; k < pixel_places; ++k) {
      if (film_.tile_tests && cover_.hides_place(triangle.mesh, place + k, nearest)) continue;
      const std::size_t before = intervals_.size();
      triangle.meet(ray(x, y, double{places_in_pixel.x[k]}, double{places_in_pixel.y[k]}), light.from(),
                    light.to(), place + k, static_cast<std::uint32_t>(triangles_.size()), intervals_);
      if (!triangle.opaque) continue;
      for (std::size_t i = before; i < intervals_.size(); ++i)
        cover_.add(triangle.mesh, place + k, intervals_[i].begin, intervals_[i].end, intervals_[i].farthest,
                   light.from(), light.to());
    }
  }

  /// Numbers triangles as the mesh has them, which tells those at equal depths apart.
  void restore_order() {
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
  void shorten(const Window& window) {
    counters.held = std::max<std::uint64_t>(counters.held, intervals_.size());
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
  void sort_by_place(const Window& window) {
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
  void merge_places() {
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

  void resolve(const Window& window) {
    sort_by_place(window);
    if (lossy_.most() > 0) merge_places();
    std::size_t place = 0;
    for (int y = window.y; y < window.y + window.height; ++y)
      for (int x = window.x; x < window.x + window.width; ++x, place += pixel_places) {
        if (film_.stop.stop_requested()) return;
        LightSum sum;
        const std::size_t begin = starts_[place], end = starts_[place + pixel_places];
        if (begin < end) resolve_pixel(x, y, rows_[static_cast<std::size_t>(y - window.y)], place, sum);
        store(x, y, sum);
        if (film_.probe != nullptr && begin < end) probe(x, y, place);
      }
  }

  void resolve_pixel(int x, int y, const LightOverTime& light, std::size_t place, LightSum& sum) {
    const std::size_t begin = starts_[place], end = starts_[place + pixel_places];
    ++counters.pixels;
    counters.most_intervals = std::max<std::uint64_t>(counters.most_intervals, end - begin);
    const PlaceRays at = rays(x, y);
    const std::uint32_t mesh = triangles_[sorted_[begin].source].mesh;
    const std::span<PlaceInterval> all(sorted_.data() + begin, end - begin);
    if (std::any_of(all.begin(), all.end(),
                    [&](const PlaceInterval& i) { return triangles_[i.source].mesh != mesh; })) {
      ++counters.mixed_pixels;
      std::stable_sort(all.begin(), all.end(), [](const PlaceInterval& a, const PlaceInterval& b) {
        return std::tie(a.place, a.source) < std::tie(b.place, b.source);
      });
      pixel_.resolve(all, triangles_, at, light, sweep_, sum);
      return;
    }
    for (std::size_t k = 0; k < pixel_places; ++k) {
      const std::size_t first = starts_[place + k], last = starts_[place + k + 1];
      if (first == last) continue;
      sweep_.cut(std::span(sorted_.data() + first, last - first), triangles_, at[k]);
      LightSum of_place;
      for (const PlacePiece& piece : sweep_.pieces()) {
        const std::span<const std::uint32_t> seen(sweep_.seen().data() + piece.first, piece.count);
        const bool even =
            std::all_of(seen.begin(), seen.end(), [&](std::uint32_t t) { return triangles_[t].plain; });
        add_light(
            light.share(piece.begin), light.share(piece.end), even, light,
            [&](double time) { return light_at(seen, triangles_, at[k], time); }, of_place);
      }
      sum.add(of_place, 1.0 / pixel_places);
    }
  }

  /// Names what is nearest at each of the probe's times, of all meshes.
  void probe(int x, int y, std::size_t place) {
    MeshProbe& probe = *film_.probe;
    const PlaceRays at = rays(x, y);
    std::size_t to = (static_cast<std::size_t>(y - image_.y) * static_cast<std::size_t>(image_.width) +
                      static_cast<std::size_t>(x - image_.x)) *
                     pixel_places * probe.times.size();
    for (std::size_t k = 0; k < pixel_places; ++k) {
      const std::size_t first = starts_[place + k], last = starts_[place + k + 1];
      sweep_.cut(std::span(sorted_.data() + first, last - first), triangles_, at[k]);
      std::size_t piece = 0;
      for (const double time : probe.times) {
        const std::vector<PlacePiece>& pieces = sweep_.pieces();
        while (piece < pieces.size() && pieces[piece].end <= time) ++piece;
        if (piece < pieces.size() && pieces[piece].begin <= time) {
          const TriangleStretch& seen = triangles_[sweep_.seen()[pieces[piece].first]];
          probe.triangles[to] = film_.first_triangle[seen.mesh] + seen.triangle;
        }
        ++to;
      }
    }
  }

  void store(int x, int y, const LightSum& sum) {
    const std::size_t i = static_cast<std::size_t>(y - image_.y) * static_cast<std::size_t>(image_.width) +
                          static_cast<std::size_t>(x - image_.x);
    const double left = std::max(0.0, 1.0 - sum.v[3]);
    for (std::size_t c = 0; c < 4; ++c)
      image_.rgba[4 * i + c] =
          static_cast<float>(sum.v[c] + left * double{film_.scene.background[static_cast<int>(c)]});
    image_.depth[i] =
        sum.v[3] > 0.0 ? static_cast<float>(sum.v[4] / sum.v[3]) : std::numeric_limits<float>::infinity();
  }

  const MeshFilm& film_;
  Image& image_;
  LossyIntervals lossy_;
  std::size_t shorten_at_ = 0, merged_ = 0;
  TileCover cover_;
  BlockTests blocks_;
  std::vector<std::pair<float, std::uint32_t>> order_;  ///< entries by their nearest depth
  std::vector<std::uint32_t> entry_of_, rank_;          ///< of triangles_
  PlaceSweep sweep_;
  MeshPixel pixel_;
  std::vector<LightOverTime> rows_;  ///< of the window
  std::vector<TriangleStretch> triangles_, reordered_;
  std::vector<PlaceInterval> intervals_, sorted_;
  std::vector<std::size_t> starts_, fill_;
};

void describe(const MeshFilm& film, const MeshBins& bins, const Counters& c, Statistics& s) {
  std::size_t triangles = 0, stretches = 0;
  int degree = 0;
  for (const MovingMesh& mesh : film.meshes) {
    triangles += mesh.object().triangles.size();
    stretches = std::max(stretches, mesh.stretches());
    degree = std::max(degree, mesh.degree());
  }
  s.count("triangles", static_cast<double>(triangles));
  s.count("segments", static_cast<double>(stretches));
  s.count("path_degree", degree);
  s.count("tile_entries", static_cast<double>(bins.entry_count()));
  s.count("tiles_split", static_cast<double>(c.split_tiles));
  s.count("fragments", static_cast<double>(c.intervals));
  s.count("fragments_held", static_cast<double>(c.held));
  s.count("fragments_in_fullest_pixel", static_cast<double>(c.most_intervals));
  s.count("pixels_swept", static_cast<double>(c.pixels));
  s.count("pixels_of_several_meshes", static_cast<double>(c.mixed_pixels));
  s.count("intervals", static_cast<double>(c.sweep.pieces));
  s.count("intervals_cut_by_crossings", static_cast<double>(c.sweep.crossings));
  s.effect("motion blur: triangles swept at 16 places of a pixel, on paths of degree " +
           std::to_string(degree) + " in " + std::to_string(stretches) +
           (stretches == 1 ? " stretch" : " stretches at most"));
}

}  // namespace

Result<Rendered> render_exact_meshes(const Scene& scene, const AbufferOptions& options,
                                     const RenderControl& control, MeshProbe* probe) {
  Rendered out;
  Stopwatch watch;
  const Exposure exposure = scene.exposure();
  MeshFilm film{scene,
                exposure,
                exposure.of_all_rows(scene.film.height),
                {},
                {},
                options.tile_fragments,
                options.place_intervals,
                options.tile_tests,
                control.stop,
                probe,
                {}};
  film.projection = projection_of(scene.film, scene.camera.at(film.all.middle()));
  // A tenth of what chords may be off by: parabolas are that much better, and edges show it.
  const double tolerance_px = scene.motion.tolerance_px > 0.0 ? scene.motion.tolerance_px : 0.01;
  std::uint32_t triangles = 0;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].triangles.empty()) continue;
    if (control.stop.stop_requested()) return stopped_error();
    Result<MovingMesh> mesh =
        MovingMesh::follow(scene, scene.objects[i], film.all, tolerance_px, control.stop);
    if (!mesh) {
      Error error = mesh.error();
      error.field = "/objects/" + std::to_string(i);
      return error;
    }
    film.first_triangle.push_back(triangles);
    triangles += static_cast<std::uint32_t>(scene.objects[i].triangles.size());
    film.meshes.push_back(std::move(*mesh));
  }
  out.statistics.time("paths", watch.lap());
  out.image = blank_image(scene.film);
  if (probe != nullptr)
    probe->triangles.assign(out.image.pixel_count() * pixel_places * probe->times.size(), no_triangle);
  const MeshBins bins(film.meshes, film.projection, scene.camera.near,
                      {out.image.x, out.image.y, out.image.width, out.image.height}, options.tile_px,
                      control.stop);
  if (control.stop.stop_requested()) return stopped_error();
  out.statistics.time("bins", watch.lap());
  PerThread<MeshTile> tiles([&] { return MeshTile(film, out.image); });
  ProgressOf done(control, bins.tile_count());
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, bins.tile_count(), 1), [&](const auto& range) {
    MeshTile& local = tiles.local();
    for (std::size_t tile = range.begin(); tile != range.end(); ++tile) {
      if (control.stop.stop_requested()) return;
      local.render(bins.window(tile), bins.entries(tile));
      done.one_more();
    }
  });
  if (control.stop.stop_requested()) return stopped_error();
  out.statistics.time("tiles", watch.lap());
  Counters total;
  for (const MeshTile& tile : tiles) {
    total.intervals += tile.counters.intervals;
    total.held = std::max(total.held, tile.counters.held);
    total.most_intervals = std::max(total.most_intervals, tile.counters.most_intervals);
    total.split_tiles += tile.counters.split_tiles;
    total.pixels += tile.counters.pixels;
    total.mixed_pixels += tile.counters.mixed_pixels;
    total.sweep.add(tile.sweep_counters());
  }
  describe(film, bins, total, out.statistics);
  return out;
}

}  // namespace swept
