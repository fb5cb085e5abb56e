#include "abuffer/tiles/cells.h"

#include <algorithm>
#include <cmath>

#include "abuffer/parallel.h"
#include "abuffer/tiles/path_frames.h"

namespace swept {
namespace {

/// Packets that one thread follows before it takes more.
constexpr std::size_t run = 512;

PacketBounds joined(const PacketBounds& a, const PacketBounds& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.x_min, b.x_min), std::max(a.x_max, b.x_max), std::min(a.y_min, b.y_min),
          std::max(a.y_max, b.y_max), std::min(a.nearest, b.nearest)};
}

/// How far the middle lies from half-way between the ends.
double bend(double first, double middle, double last) {
  const double off = std::abs(middle - (0.5 * first + 0.5 * last));
  return std::isfinite(off) ? off : 0.0;
}
double bend(const PacketBounds& a, const PacketBounds& middle, const PacketBounds& b) {
  return std::max({bend(a.x_min, middle.x_min, b.x_min), bend(a.x_max, middle.x_max, b.x_max),
                   bend(a.y_min, middle.y_min, b.y_min), bend(a.y_max, middle.y_max, b.y_max)});
}

/// One packet at the beginning, the middle and the end of a part of its path.
struct Part {
  const ObjectInstant* at[3];
  Eigen::Vector3d center[3];

  [[nodiscard]] bool finite() const {
    return center[0].allFinite() && center[1].allFinite() && center[2].allFinite();
  }

  /// The least of what a sphere of radius `reach(i)` about the centre has of a linear function of camera
  /// space, `of` being that of the centre, or less.
  template <class Of, class Reach>
  [[nodiscard]] double least(const Of& of, const Reach& reach) const {
    const double v[3] = {of(0), of(1), of(2)};
    return std::min({v[0] - reach(0), v[1] - reach(1), v[2] - reach(2)}) - 2.0 * bend(v[0], v[1], v[2]);
  }
};

/// Where a packet is in relation to the near plane and to the film's pyramid during a part of its path.
enum class Passage {
  in_front,  ///< of the near plane throughout
  outside,   ///< behind it, or beside the film
  through,   ///< perhaps through the plane, and anywhere on the film
};
Passage passage_of(const Scene& scene, const Part& part, double radius) {
  if (!part.finite()) return Passage::through;
  const auto reach = [&](int i) { return radius * part.at[i]->enlarges; };
  const auto depth = [&](int i) { return part.center[i].z(); };
  if (part.least(depth, reach) > scene.camera.near) return Passage::in_front;
  if (part.least([&](int i) { return -depth(i); }, reach) > -scene.camera.near) return Passage::outside;
  // Near the eye a lens spreads points beyond any bound.
  if (scene.camera.aperture.radius > 0.0) return Passage::through;
  for (int axis = 0; axis < 2; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const auto half = [&](int i) {
        const Projection& p = part.at[i]->projection;
        const double middle = axis == 0 ? p.center_x : p.center_y;
        return side < 0.0 ? middle : (axis == 0 ? scene.film.width : scene.film.height) - middle;
      };
      // Beyond the film's edge where focal·x > half·z; the filter, and a pixel more, widen a disc where its
      // centre is.
      const auto beyond = [&](int i) {
        const Projection& p = part.at[i]->projection;
        return side * p.focal_px * part.center[i][axis] - half(i) * p.divisor(depth(i));
      };
      const auto widest = [&](int i) {
        const Projection& p = part.at[i]->projection;
        return reach(i) * std::hypot(p.focal_px, half(i)) +
               (scene.model.filter_radius_px + 1.0) * std::max(0.0, p.divisor(depth(i) + reach(i)));
      };
      if (part.least(beyond, widest) > 0.0) return Passage::outside;
    }
  return Passage::through;
}

/// Parts of a stretch of a packet's path between two looks.
std::size_t parts_of(const PointPackets& packets) {
  return packets.degree == 1 ? 1 : std::max<std::size_t>(8, 2 * packets.degree);
}

/// Frames at which the path of the packets has to be looked at.
std::vector<double> looks(const PointPackets& packets) {
  const std::size_t parts = parts_of(packets);
  if (parts == 1) return packets.frames;
  std::vector<double> frames{packets.frames.front()};
  for (std::size_t j = 1; j < packets.frames.size(); ++j)
    for (std::size_t part = 1; part <= parts; ++part) {
      const double share = static_cast<double>(part) / static_cast<double>(parts);
      frames.push_back(packets.frames[j - 1] + share * (packets.frames[j] - packets.frames[j - 1]));
    }
  return frames;
}

/// How far the path of packet `p` may be from chords between looks(), object space: a curve of degree d
/// leaves the chord over a share h of it by d(d − 1) h²/8 times its control points' largest second
/// difference.
double chord_error(const PointPackets& packets, std::size_t p) {
  if (packets.degree == 1) return 0.0;
  double largest = 0.0;
  for (std::size_t k = 0; k + 2 < packets.origins.size(); ++k) {
    // Across the ends of stretches it means nothing.
    if (k % packets.degree + 2 > packets.degree) continue;
    largest = std::max(
        largest,
        (packets.origins[k + 2][p] - 2.0 * packets.origins[k + 1][p] + packets.origins[k][p]).norm());
  }
  const auto d = static_cast<double>(packets.degree), parts = static_cast<double>(parts_of(packets));
  return d * (d - 1.0) / 8.0 * largest / (parts * parts);
}

/// What changes in a packet besides where it is, as so many pixels of motion as take as many instants.
class ChangesOf {
 public:
  ChangesOf(const Scene& scene, const PointPackets& packets, const Exposure& of_row)
      : cloud_(packets.object->cloud), packets_(packets), of_row_(of_row) {
    const Exposure all = of_row.of_all_rows(scene.film.height);
    const ObjectInstant middle(scene, packets, all.middle());
    all_ = all;
    const double depth = packets.count > 0 ? middle.center(packets, 0).z() : 0.0;
    per_unit_ = middle.enlarges * middle.projection.focal_px /
                middle.projection.divisor(std::max(depth, scene.camera.near));
    if (!std::isfinite(per_unit_)) per_unit_ = 0.0;
  }

  [[nodiscard]] double px(std::size_t p) const {
    double most = 0.0;
    if (!packets_.mortal && !packets_.spins && packets_.looks.empty()) return most;
    for (std::size_t lane = 0; lane < packet_size; ++lane) {
      const std::uint32_t i = packets_.points[p * packet_size + lane];
      if (packets_.spins) {
        const double rate = cloud_.angular_velocity[i].cast<double>().stableNorm();
        most = std::max(most, std::min(1e4, rate * (of_row_.close - of_row_.open) *
                                                double{packets_.radius[p]} * per_unit_));
      }
      if (!packets_.looks.empty()) most = std::max(most, px_of_looks(p, lane));
      if (!packets_.mortal) continue;
      const Lifetime& life = cloud_.lifetime[i];
      const auto during = [&](double frame) { return frame > all_.open && frame < all_.close; };
      // All its pixels jump at once, which no alternating sum need see.
      constexpr double jump_px = 256.0;
      if (during(life.born) || during(life.gone)) most = std::max(most, jump_px);
    }
    return most;
  }

 private:
  /// What changes evenly any number of instants has right; it is others that it shows by and by.
  [[nodiscard]] double px_of_looks(std::size_t p, std::size_t lane) const {
    const double of_one = packets_.looks.size() > 2 ? 32.0 : 4.0;
    float most = 0.0f;
    for (std::size_t k = 1; k < packets_.looks.size(); ++k)
      for (std::size_t c = 0; c < 4; ++c) {
        const std::size_t at = (4 * p + c) * packet_size + lane;
        most = std::max(most, std::abs(packets_.looks[k].colors[at] - packets_.looks[k - 1].colors[at]));
      }
    return of_one * double{std::min(most, 1.0f)};
  }

  const SurfelCloud& cloud_;
  const PointPackets& packets_;
  Exposure of_row_, all_;
  double per_unit_ = 0.0;
};

}  // namespace

PacketBins::PacketBins(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects)
    : film_(scene.film),
      cell_height_(exposure.row_delay == 0.0 ? cell_px : 1),
      columns_(static_cast<std::size_t>((film_.width + cell_px - 1) / cell_px)),
      rows_(static_cast<std::size_t>((film_.height + cell_height_ - 1) / cell_height_)),
      motion_(objects.size()),
      starts_(columns_ * rows_ + 1, 0) {
  for (std::size_t object = 0; object < objects.size(); ++object)
    follow(scene, exposure, objects[object], object);
  for (const std::vector<Touch>& touches : touched_)
    for (const Touch& touch : touches) ++starts_[touch.cell + 1];
  for (std::size_t cell = 0; cell < cell_count(); ++cell) starts_[cell + 1] += starts_[cell];
  entries_.resize(starts_.back());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (const std::vector<Touch>& touches : touched_)
    for (const Touch& touch : touches) entries_[next[touch.cell]++] = touch.packet;
  touched_.clear();
  touched_.shrink_to_fit();
}

Cell PacketBins::cell(std::size_t index) const {
  const int x = static_cast<int>(index % columns_) * cell_px,
            y = static_cast<int>(index / columns_) * cell_height_;
  return {x, y, std::min(cell_px, film_.width - x), std::min(cell_height_, film_.height - y)};
}

void PacketBins::follow(const Scene& scene, const Exposure& of_row, const PointPackets& packets,
                        std::size_t object) {
  const bool still = stands_still(scene, *packets.object, of_row);
  const Exposure exposure = of_row.of_all_rows(film_.height);
  const std::vector<double> frames = still ? std::vector<double>{exposure.open}
                                           : path_frames(scene, *packets.object, looks(packets), exposure);
  // What turns too fast to be followed may be anywhere.
  const bool lost = frames.empty();
  std::vector<ObjectInstant> instants;
  instants.reserve(2 * frames.size() + 1);
  if (lost) instants.emplace_back(scene, packets, exposure.open);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i > 0) instants.emplace_back(scene, packets, 0.5 * frames[i - 1] + 0.5 * frames[i]);
    instants.emplace_back(scene, packets, frames[i]);
  }
  motion_[object].assign(packets.count, {});
  const std::size_t runs = (packets.count + run - 1) / run, first_run = touched_.size();
  touched_.resize(first_run + runs);
  const double farthest = 4.0 * (film_.width + film_.height);
  // Of the way that a packet goes over all rows' exposures a row sees this much.
  const double seen =
      exposure.close > exposure.open ? (of_row.close - of_row.open) / (exposure.close - exposure.open) : 1.0;
  const ChangesOf changes(scene, packets, of_row);
  const PacketBounds everywhere{0.0, double{1.0} * film_.width, 0.0, double{1.0} * film_.height, 0.0};
  parallel_for_each_index(runs, [&](std::size_t r) {
    std::vector<Touch>& touches = touched_[first_run + r];
    std::vector<std::uint32_t> cells;
    for (std::size_t p = r * run; p < std::min((r + 1) * run, packets.count); ++p) {
      cells.clear();
      const auto touch = [&](const PacketBounds& box, double padding) {
        if (box.empty()) return;
        const auto cell = [](double v, int px, std::size_t count) {
          return static_cast<std::size_t>(
              std::clamp(std::floor(v / px), 0.0, static_cast<double>(count - 1)));
        };
        if (!(box.x_max + padding >= 0.0 && box.x_min - padding <= film_.width &&
              box.y_max + padding >= 0.0 && box.y_min - padding <= film_.height))
          return;
        const std::size_t y_last = cell(box.y_max + padding, cell_height_, rows_),
                          x_last = cell(box.x_max + padding, cell_px, columns_);
        for (std::size_t y = cell(box.y_min - padding, cell_height_, rows_); y <= y_last; ++y)
          for (std::size_t x = cell(box.x_min - padding, cell_px, columns_); x <= x_last; ++x)
            cells.push_back(static_cast<std::uint32_t>(y * columns_ + x));
      };
      // About a path of chords between the frames looked at.
      const double radius = double{packets.radius[p]} + 2.0 * chord_error(packets, p);
      Part part;
      part.at[2] = instants.data();
      part.center[2] = instants[0].center(packets, p);
      PacketBounds before = instants[0].bounds(part.center[2], radius);
      double length = lost ? farthest : 0.0;
      if (lost) touch(everywhere, 0.0);
      if (still) {
        // What reaches through the near plane beside the film or below it has no bounds there.
        part.at[0] = part.at[1] = part.at[2];
        part.center[0] = part.center[1] = part.center[2];
        if (passage_of(scene, part, radius) != Passage::outside) touch(before, 0.0);
      }
      for (std::size_t i = 1; i < instants.size(); i += 2) {
        part.at[0] = part.at[2];
        part.center[0] = part.center[2];
        PacketBounds at[2];
        for (std::size_t half = 0; half < 2; ++half) {
          const ObjectInstant& next = instants[i + half];
          const Eigen::Vector3d moved = next.center(packets, p), &from = part.center[half];
          at[half] = next.bounds(moved, radius);
          if (moved.z() > scene.camera.near && from.z() > scene.camera.near) {
            const Projection& film = next.projection;
            const double far =
                (moved.head<2>() / film.divisor(moved.z()) - from.head<2>() / film.divisor(from.z())).norm();
            length += std::min(farthest, next.projection.focal_px * far);
          } else if (moved != from) {
            length += 1.0;
          }
          part.at[half + 1] = &next;
          part.center[half + 1] = moved;
        }
        // A smooth path is nowhere farther from its chord than about where the middle is.
        const Passage passage = passage_of(scene, part, radius);
        if (passage == Passage::in_front)
          touch(joined(before, joined(at[0], at[1])), 1.0 + 2.0 * bend(before, at[0], at[1]));
        else if (passage == Passage::through)
          touch(everywhere, 0.0);
        before = at[1];
      }
      length *= seen;
      // Whatever may move is not still, however little.
      if (!still) length = std::max(length + changes.px(p), 1e-9);
      std::sort(cells.begin(), cells.end());
      cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
      motion_[object][p] = {static_cast<float>(std::min(length, farthest)), static_cast<float>(cells.size())};
      for (const std::uint32_t cell : cells)
        touches.push_back({cell, {static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(p)}});
    }
  });
}

}  // namespace swept
