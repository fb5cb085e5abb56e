#include "abuffer/tiles/mesh_motion.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "abuffer/tiles/path_frames.h"
#include "splat/motion/instant.h"
#include "splat/motion/path.h"

namespace swept {
namespace {

FilmBox joined(const FilmBox& a, const FilmBox& b) {
  return {std::min(a.x_min, b.x_min), std::max(a.x_max, b.x_max), std::min(a.y_min, b.y_min),
          std::max(a.y_max, b.y_max)};
}

/// How far the middle box lies from half-way between the others.
double bend(const FilmBox& a, const FilmBox& middle, const FilmBox& b) {
  const auto off = [](double first, double at, double last) { return std::abs(at - 0.5 * (first + last)); };
  return std::max({off(a.x_min, middle.x_min, b.x_min), off(a.x_max, middle.x_max, b.x_max),
                   off(a.y_min, middle.y_min, b.y_min), off(a.y_max, middle.y_max, b.y_max)});
}

}  // namespace

MeshMotion::MeshMotion(const Scene& scene, const Exposure& exposure, const CellGrid& grid)
    : squares_(grid.size(), 0.0), count_(grid.size(), 0.0) {
  for (const Object& object : scene.objects)
    if (!object.triangles.empty() && !stands_still(scene, object, exposure))
      follow(scene, object, exposure, grid);
}

float MeshMotion::px(std::size_t cell) const {
  return count_[cell] > 0.0 ? static_cast<float>(std::sqrt(squares_[cell] / count_[cell])) : 0.0f;
}

void MeshMotion::follow(const Scene& scene, const Object& object, const Exposure& exposure,
                        const CellGrid& grid) {
  std::vector<double> frames;
  for (const SurfelKey& key : object.cloud.keys)
    if (key.frame > exposure.open && key.frame < exposure.close) frames.push_back(key.frame);
  // Between two looks a curve must not bend both ways.
  if (object.cloud.curved() && !exposure.instant()) {
    std::vector<double> ends(frames);
    ends.insert(ends.begin(), exposure.open);
    ends.push_back(exposure.close);
    const std::size_t parts = std::max<std::size_t>(8, 2 * path_degree(object.cloud));
    for (std::size_t k = 1; k < ends.size(); ++k)
      for (std::size_t part = 1; part < parts; ++part)
        frames.push_back(ends[k - 1] +
                         (ends[k] - ends[k - 1]) * static_cast<double>(part) / static_cast<double>(parts));
  }
  frames = path_frames(scene, object, frames, exposure);
  const double farthest = 4.0 * (grid.film.width + grid.film.height);
  // What turns too fast to be followed may be anywhere.
  if (frames.size() < 2) {
    for (std::size_t c = 0; c < grid.size(); ++c) squares_[c] += farthest * farthest, count_[c] += 1.0;
    return;
  }
  struct Track {
    std::optional<FilmBox> box;
    double length = 1e-9;  ///< whatever may move is not still, however little
    std::vector<std::uint32_t> cells;
  };
  std::vector<Track> tracks(object.triangles.size());
  const auto touch = [&](Track& track, const CellRange& range) {
    for (std::size_t y = range.y_begin; y < range.y_end; ++y)
      for (std::size_t x = range.x_begin; x < range.x_end; ++x)
        track.cells.push_back(static_cast<std::uint32_t>(y * grid.columns + x));
  };
  std::optional<MeshInstant> first;
  first.emplace(scene, object, frames.front());
  for (std::size_t t = 0; t < tracks.size(); ++t) tracks[t].box = first->box(t);
  const auto in_front = [](const MeshInstant& at, std::size_t t) {
    return at.corner(t, 0).z() > at.near() && at.corner(t, 1).z() > at.near() &&
           at.corner(t, 2).z() > at.near();
  };
  const auto behind = [](const MeshInstant& at, std::size_t t) {
    return at.corner(t, 0).z() < at.near() && at.corner(t, 1).z() < at.near() &&
           at.corner(t, 2).z() < at.near();
  };
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    const MeshInstant middle(scene, object, 0.5 * frames[i] + 0.5 * frames[i + 1]);
    MeshInstant last(scene, object, frames[i + 1]);
    for (std::size_t t = 0; t < tracks.size(); ++t) {
      Track& track = tracks[t];
      const std::optional<FilmBox> at_middle = middle.box(t), at_last = last.box(t);
      if (in_front(*first, t) && in_front(middle, t) && in_front(last, t) && track.box && at_middle &&
          at_last) {
        // A smooth path is nowhere farther from its chord than about where the middle is.
        const double bent = bend(*track.box, *at_middle, *at_last);
        touch(track, cells_of(joined(*track.box, joined(*at_middle, *at_last)), 1.0 + 2.0 * bent, grid));
        const auto moved = [&](const MeshInstant& a, const MeshInstant& b) {
          double most = 0.0;
          for (std::size_t c = 0; c < 3; ++c) {
            const Eigen::Vector3d &p = a.corner(t, c), &q = b.corner(t, c);
            const Projection& film = b.projection();
            most = std::max(
                most, film.focal_px *
                          (q.head<2>() / film.divisor(q.z()) - p.head<2>() / film.divisor(p.z())).norm());
          }
          return most;
        };
        track.length += moved(*first, middle) + moved(middle, last);
      } else if (!(behind(*first, t) && behind(middle, t) && behind(last, t))) {
        touch(track, {0, grid.columns, 0, grid.rows});
        track.length += farthest;
      }
      track.box = at_last;
    }
    first.emplace(std::move(last));
  }
  for (Track& track : tracks) {
    std::sort(track.cells.begin(), track.cells.end());
    track.cells.erase(std::unique(track.cells.begin(), track.cells.end()), track.cells.end());
    const double length = std::min(track.length, farthest);
    for (const std::uint32_t c : track.cells) squares_[c] += length * length, count_[c] += 1.0;
  }
}

}  // namespace swept
