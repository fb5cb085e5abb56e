#include "abuffer/splats/film_motion.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <mutex>

#include "abuffer/parallel.h"
#include "abuffer/splats/splat_cell.h"
#include "abuffer/tiles/path_frames.h"

namespace swept {
namespace {

/// Packets that one thread follows before it takes more.
constexpr std::size_t packets_a_run = 128;

/// Side of a film on which splats are followed beyond the real one's edges.
constexpr int wide_film_px = 65536;

using Lanes = std::array<PlacedSplat, static_cast<std::size_t>(packet_size)>;

/// A packet's splats at one frame, lane by lane.
struct PlacedLanes {
  std::uint32_t seen = 0;
  Lanes lanes;
};

PlacedLanes placed_lanes(const SplatMath& math, const SplatFields& fields, const SplatView& view,
                         const SplatOrigin& origin) {
  PlacedLanes placed;
  Lanes compact;
  placed.seen = math.place(fields, view, origin, compact.data());
  std::size_t next = 0;
  for (std::uint32_t rest = placed.seen; rest != 0; rest &= rest - 1)
    placed.lanes[static_cast<std::size_t>(std::countr_zero(rest))] = compact[next++];
  return placed;
}

double center_x(const PlacedSplat& s) { return double{s.pixel_x} + 0.5 - double{s.center_x}; }
double center_y(const PlacedSplat& s) { return double{s.pixel_y} + 0.5 - double{s.center_y}; }

/// A vector on the film in standard deviations of a splat.
double in_deviations(const PlacedSplat& s, double dx, double dy) {
  constexpr double half_log2_e = 0.72134752044448170;
  const double u = double{s.ux} * dx + double{s.uy} * dy, v = double{s.vy} * dy;
  return std::sqrt((u * u + v * v) / half_log2_e);
}

struct Box {
  double x_first, x_last, y_first, y_last;

  explicit Box(const PlacedSplat& s)
      : x_first(s.x_first), x_last(s.x_last), y_first(s.y_first), y_last(s.y_last) {}
  void join(const Box& other) {
    x_first = std::min(x_first, other.x_first), x_last = std::max(x_last, other.x_last);
    y_first = std::min(y_first, other.y_first), y_last = std::max(y_last, other.y_last);
  }
  /// How far the middle one of three lies from half-way between the others.
  static double bend(const Box& a, const Box& m, const Box& b) {
    const auto off = [](double first, double middle, double last) {
      return std::abs(middle - 0.5 * (first + last));
    };
    return std::max(std::max(off(a.x_first, m.x_first, b.x_first), off(a.x_last, m.x_last, b.x_last)),
                    std::max(off(a.y_first, m.y_first, b.y_first), off(a.y_last, m.y_last, b.y_last)));
  }
};

/// Where a tile has its i-th pixel.
struct TilePlace {
  int x, y;
};
TilePlace tile_place(int i) { return {4 * (i / 16 % 8) + i % 4, 4 * (i / 128) + i / 4 % 4}; }

void largest(std::atomic<float>& most, float value) {
  float seen = most.load(std::memory_order_relaxed);
  while (seen < value && !most.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
}

/// What few pixels exceed; but where few see anything move, a share of what they see.
float typical(std::vector<float>& spreads) {
  const auto few = spreads.begin() + static_cast<std::ptrdiff_t>(spreads.size() * 85 / 100);
  std::nth_element(spreads.begin(), few, spreads.end());
  return std::max(*few, *std::max_element(spreads.begin(), spreads.end()) / 3.0f);
}

}  // namespace

FilmMotion::FilmMotion(const Scene& scene, const Exposure& exposure, const std::vector<SplatPackets>& sets,
                       const SplatRow& standing, const SplatMath& math, const CellGrid& grid)
    : touched_(grid.size(), 0), spread_(grid.size(), 0.0f) {
  of_sets_.resize(sets.size());
  bool any = false;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    if (!sets[i].moves) continue;
    any = true;
    follow(scene, exposure, sets[i], math, grid, of_sets_[i]);
  }
  if (!any) return;
  for (const double share : {0.0, 0.5, 1.0})
    look(scene, sets, exposure.at(share), standing, math, grid, Look::spreads);
}

void FilmMotion::look_for_ways(const Scene& scene, const std::vector<SplatPackets>& sets, double frame,
                               const SplatRow& standing, const SplatMath& math, const CellGrid& grid) {
  look(scene, sets, frame, standing, math, grid, Look::ways);
  spread_ways(grid.film);
}

void FilmMotion::follow(const Scene& scene, const Exposure& exposure, const SplatPackets& set,
                        const SplatMath& math, const CellGrid& grid, Ways& ways) {
  std::vector<double> frames = path_frames(scene, *set.object, {exposure.open, exposure.close}, exposure);
  // What turns too fast to be followed may be anywhere, and so may all where the camera moves.
  const bool anywhere = frames.empty() || !scene.camera.constant_over(exposure.open, exposure.close);
  if (frames.empty()) frames = {exposure.open, exposure.close};
  // Where all cells are taken for touched, a path need not be followed that closely.
  constexpr std::size_t enough = 33;
  if (anywhere && frames.size() > enough) {
    frames.clear();
    for (std::size_t i = 0; i < enough; ++i)
      frames.push_back(exposure.at(static_cast<double>(i) / (enough - 1)));
  }
  std::vector<SplatPose> poses;
  poses.reserve(2 * frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i > 0) poses.emplace_back(scene, set, 0.5 * frames[i - 1] + 0.5 * frames[i]);
    poses.emplace_back(scene, set, frames[i]);
  }
  const int shift_x = (wide_film_px - grid.film.width) / 2, shift_y = (wide_film_px - grid.film.height) / 2;
  for (SplatPose& pose : poses) pose.view.film_width = pose.view.film_height = wide_film_px;

  ways.assign(set.count * static_cast<std::size_t>(packet_size), Way{});
  std::vector<std::atomic<char>> touched(grid.size());
  std::atomic<bool> lost{anywhere}, jumps{jumps_};
  std::atomic<float> fastest{fastest_px_}, widest{fastest_spread_};
  parallel_for_each_index((set.count + packets_a_run - 1) / packets_a_run, [&](std::size_t r) {
    std::vector<PlacedLanes> at(poses.size());
    for (std::size_t p = r * packets_a_run; p < std::min((r + 1) * packets_a_run, set.count); ++p) {
      for (std::size_t k = 0; k < poses.size(); ++k) {
        SplatOrigin origin = poses[k].origin(set, p);
        origin.pixel_x += shift_x, origin.pixel_y += shift_y;
        at[k] = placed_lanes(math, set.fields(p), poses[k].view, origin);
      }
      for (std::size_t lane = 0; lane < static_cast<std::size_t>(packet_size); ++lane) {
        const auto seen = [&](std::size_t k) { return (at[k].seen >> lane & 1u) != 0; };
        double length = 0.0, spread = 0.0, way_x = 0.0, way_y = 0.0;
        for (std::size_t k = 0; k + 1 < at.size(); ++k) {
          if (!seen(k) || !seen(k + 1)) {
            // Through the near plane, or from far away.
            if (seen(k) != seen(k + 1)) {
              lost.store(true, std::memory_order_relaxed);
              const PlacedSplat& one = at[seen(k) ? k : k + 1].lanes[lane];
              if (one.x_last >= shift_x && one.x_first < shift_x + grid.film.width && one.y_last >= shift_y &&
                  one.y_first < shift_y + grid.film.height)
                jumps.store(true, std::memory_order_relaxed);
            }
            continue;
          }
          const PlacedSplat &a = at[k].lanes[lane], &b = at[k + 1].lanes[lane];
          const double dx = center_x(b) - center_x(a), dy = center_y(b) - center_y(a);
          length += std::hypot(dx, dy);
          way_x += dx, way_y += dy;
          spread += 0.5 * (in_deviations(a, dx, dy) + in_deviations(b, dx, dy));
        }
        largest(fastest, static_cast<float>(length));
        largest(widest, static_cast<float>(spread));
        const double straight = std::hypot(way_x, way_y),
                     longer = straight > 1e-6 * length ? length / straight : 0.0;
        ways[p * static_cast<std::size_t>(packet_size) + lane] = {static_cast<float>(longer * way_x),
                                                                  static_cast<float>(longer * way_y),
                                                                  static_cast<float>(spread)};
        if (anywhere) continue;
        for (std::size_t k = 0; k + 2 < at.size(); k += 2) {
          if (!seen(k) || !seen(k + 1) || !seen(k + 2)) continue;
          const Box first(at[k].lanes[lane]), middle(at[k + 1].lanes[lane]), last(at[k + 2].lanes[lane]);
          Box box = first;
          box.join(middle);
          box.join(last);
          // A smooth path is nowhere farther from its chord than about where the middle is.
          const double padding = 1.0 + 2.0 * Box::bend(first, middle, last);
          const double left = box.x_first - shift_x - padding, right = box.x_last - shift_x + padding;
          const double top = box.y_first - shift_y - padding, bottom = box.y_last - shift_y + padding;
          if (right < 0.0 || bottom < 0.0 || left >= grid.film.width || top >= grid.film.height) continue;
          const auto cell = [](double px, std::size_t count) {
            return static_cast<std::size_t>(
                std::clamp(std::floor(px / cell_px), 0.0, static_cast<double>(count - 1)));
          };
          for (std::size_t y = cell(top, grid.rows); y <= cell(bottom, grid.rows); ++y)
            for (std::size_t x = cell(left, grid.columns); x <= cell(right, grid.columns); ++x)
              touched[y * grid.columns + x].store(1, std::memory_order_relaxed);
        }
      }
    }
  });
  jumps_ = jumps;
  fastest_px_ = fastest, fastest_spread_ = widest;
  for (std::size_t cell = 0; cell < grid.size(); ++cell)
    if (lost || touched[cell] != 0) touched_[cell] = 1;
}

/// Draws one of every few pixels, with what splats do in place of colours.
void FilmMotion::look(const Scene& scene, const std::vector<SplatPackets>& sets, double frame,
                      const SplatRow& standing, const SplatMath& math, const CellGrid& grid, Look what) {
  std::vector<PlacedSplat> splats;
  std::vector<std::size_t> discs;
  std::vector<float> fineness;
  const auto add = [&](PlacedSplat splat, const Way& way, bool disc) {
    // Pixel i of the coarse film is the fine one's middle one of its i-th few.
    constexpr int middle = pitch_px / 2;
    const int x_first = (std::max(0, splat.x_first - middle) + pitch_px - 1) / pitch_px;
    const int y_first = (std::max(0, splat.y_first - middle) + pitch_px - 1) / pitch_px;
    const int x_last = splat.x_last < middle ? -1 : (splat.x_last - middle) / pitch_px;
    const int y_last = splat.y_last < middle ? -1 : (splat.y_last - middle) / pitch_px;
    if (x_first > x_last || y_first > y_last) return;
    constexpr float pitch = pitch_px;
    if (what == Look::spreads) {
      splat.red = way.spread * way.spread;
    } else {
      // Fine splats have the frequencies that matter: they count by their inverse variances.
      const float length = std::hypot(way.x, way.y);
      const auto own = static_cast<float>(in_deviations(splat, 1.0, 0.0));
      const float per_px = length > 0.0f ? way.spread / length : own, weight = per_px * per_px;
      splat.red = weight * length, splat.green = weight * way.x, splat.blue = weight * way.y;
      fineness.push_back(weight);
    }
    splat.center_x = (static_cast<float>(middle) - splat.pixel_x + splat.center_x) / pitch;
    splat.center_y = (static_cast<float>(middle) - splat.pixel_y + splat.center_y) / pitch;
    splat.pixel_x = splat.pixel_y = 0.0f;
    splat.ux *= pitch, splat.uy *= pitch, splat.vy *= pitch;
    if (disc) splat.gx *= pitch, splat.gy *= pitch;
    splat.x_first = static_cast<std::uint16_t>(x_first), splat.x_last = static_cast<std::uint16_t>(x_last);
    splat.y_first = static_cast<std::uint16_t>(y_first), splat.y_last = static_cast<std::uint16_t>(y_last);
    if (disc) discs.push_back(splats.size());
    splats.push_back(splat);
  };
  for (std::size_t i = 0; i < sets.size(); ++i) {
    if (!sets[i].moves) continue;
    const SplatPose pose(scene, sets[i], frame);
    for (std::size_t p = 0; p < sets[i].count; ++p) {
      const PlacedLanes at = placed_lanes(math, sets[i].fields(p), pose.view, pose.origin(sets[i], p));
      for (std::uint32_t rest = at.seen; rest != 0; rest &= rest - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
        add(at.lanes[lane], of_sets_[i][p * static_cast<std::size_t>(packet_size) + lane],
            sets[i].object->splats.flat);
      }
    }
  }
  for (std::size_t i = 0; i < standing.size(); ++i) add(standing.splats()[i], {}, standing.is_disc(i));

  std::vector<std::uint32_t> order = by_depth(splats);
  std::vector<char> is_disc(splats.size(), 0);
  for (const std::size_t disc : discs) is_disc[disc] = 1;
  for (std::uint32_t& index : order)
    if (is_disc[index] != 0) index |= disc_flag;
  SplatRule rule = splat_rule(scene);
  if (what == Look::ways) {
    // Depths have sorted them, and are summed up as colours are.
    for (std::size_t i = 0; i < splats.size(); ++i) splats[i].depth = fineness[i];
    rule.near = 0.0f;
  }
  const std::size_t columns = static_cast<std::size_t>((grid.film.width - 1) / pitch_px / tile_px + 1),
                    rows = static_cast<std::size_t>((grid.film.height - 1) / pitch_px / tile_px + 1);
  std::vector<std::vector<std::uint32_t>> lists(columns * rows);
  for (const std::uint32_t index : order) {
    const PlacedSplat& s = splats[index & splat_index];
    const auto tile = [](int px, std::size_t count) {
      return std::min(static_cast<std::size_t>(px / tile_px), count - 1);
    };
    for (std::size_t y = tile(s.y_first, rows); y <= tile(s.y_last, rows); ++y)
      for (std::size_t x = tile(s.x_first, columns); x <= tile(s.x_last, columns); ++x)
        lists[y * columns + x].push_back(index);
  }
  way_columns_ = columns * static_cast<std::size_t>(tile_px);
  if (what == Look::ways) ways_.assign(columns * rows * static_cast<std::size_t>(tile_floats), Way{});
  parallel_for_each_index(columns * rows, [&](std::size_t t) {
    const int x = static_cast<int>(t % columns) * tile_px, y = static_cast<int>(t / columns) * tile_px;
    const auto tile = std::make_unique<SplatTile>();
    math.clear(*tile);
    math.draw({{splats.data(), splats.data()}, lists[t].data(), lists[t].size()}, x, y, rule, *tile);
    if (what == Look::ways)
      take_ways(*tile, x, y);
    else
      take_spreads(*tile, x, y, grid);
  });
}

/// Of the tile that begins at (x, y) of the coarse film; it covers whole cells.
void FilmMotion::take_spreads(const SplatTile& tile, int x, int y, const CellGrid& grid) {
  constexpr int px_a_cell = cell_px / pitch_px, cells_a_tile = tile_px / px_a_cell;
  static_assert(cells_a_tile * px_a_cell == tile_px);
  std::array<std::vector<float>, cells_a_tile * cells_a_tile> of_cells;
  for (int i = 0; i < tile_floats; ++i) {
    const TilePlace at = tile_place(i);
    if ((x + at.x) * pitch_px < grid.film.width && (y + at.y) * pitch_px < grid.film.height)
      of_cells[static_cast<std::size_t>(at.y / px_a_cell * cells_a_tile + at.x / px_a_cell)].push_back(
          std::sqrt(tile.blocks[i / 16].red[i % 16]));
  }
  for (std::size_t k = 0; k < of_cells.size(); ++k) {
    const auto column = static_cast<std::size_t>(x / px_a_cell) + k % cells_a_tile,
               row = static_cast<std::size_t>(y / px_a_cell) + k / cells_a_tile;
    if (of_cells[k].empty() || column >= grid.columns || row >= grid.rows) continue;
    float& most = spread_[row * grid.columns + column];
    most = std::max(most, typical(of_cells[k]));
  }
}

void FilmMotion::take_ways(const SplatTile& tile, int x, int y) {
  for (int i = 0; i < tile_floats; ++i) {
    const SplatBlock& block = tile.blocks[i / 16];
    const int lane = i % 16;
    const float fineness = block.depth[lane], alpha = 1.0f - std::abs(block.light[lane]);
    if (!(fineness > 0.0f) || !(alpha > 0.0f)) continue;
    const float straight = std::hypot(block.green[lane], block.blue[lane]),
                length = block.red[lane] / fineness;
    // Where ways cancel each other the film's rows are as good as any direction.
    const bool anywhere = !(straight > 1e-4f * block.red[lane]);
    Way& way = ways_[static_cast<std::size_t>(y + tile_place(i).y) * way_columns_ +
                     static_cast<std::size_t>(x + tile_place(i).x)];
    way.x = anywhere ? length : length * block.green[lane] / straight;
    way.y = anywhere ? 0.0f : length * block.blue[lane] / straight;
    way.spread = length * std::sqrt(fineness / alpha);
  }
}

/// To the pixels by which what is seen comes before or after, if what is seen there is coarser.
void FilmMotion::spread_ways(const Film& film) {
  const std::vector<Way> seen = ways_;
  const int columns = (film.width - 1) / pitch_px + 1, rows = (film.height - 1) / pitch_px + 1;
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * way_columns_ + static_cast<std::size_t>(x);
  };
  constexpr float coarser = 1.5f;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const Way& way = seen[at(x, y)];
      const float length = std::hypot(way.x, way.y);
      if (!(length >= 1.0f)) continue;
      const float reach = std::min(0.5f * length, static_cast<float>(film.width + film.height)) / pitch_px;
      for (float far = -std::floor(reach); far <= reach; far += 1.0f) {
        const int to_x = static_cast<int>(std::floor(static_cast<float>(x) + 0.5f + far * way.x / length)),
                  to_y = static_cast<int>(std::floor(static_cast<float>(y) + 0.5f + far * way.y / length));
        if (to_x < 0 || to_y < 0 || to_x >= columns || to_y >= rows) continue;
        Way& there = ways_[at(to_x, to_y)];
        if (way.spread > coarser * seen[at(to_x, to_y)].spread && way.spread > there.spread) there = way;
      }
    }
}

int first_splat_instants(float spread, double max_error_db) {
  // The error falls as a bell's spectrum does: its logarithm with the square of N.
  const double scale = std::sqrt(std::max(0.1, (max_error_db - 17.0) / 43.0));
  const double wanted = std::max(2.0, (1.0 + 0.5 * double{spread}) * scale);
  int count = 2;
  while (count < wanted && count < (1 << 14))
    count = (count & (count - 1)) == 0 ? count + count / 2 : count / 3 * 4;
  return count;
}

}  // namespace swept
