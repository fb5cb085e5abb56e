// Looks at one of every few pixels of the film: what moves there, how far, and what it changes in passing.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "abuffer/parallel.h"
#include "abuffer/splats/film_motion.h"
#include "abuffer/splats/placed_lanes.h"
#include "abuffer/splats/posed_packet.h"
#include "abuffer/splats/splat_cell.h"

namespace swept {
namespace {

/// Where a tile has its i-th pixel.
struct TilePlace {
  int x, y;
};
TilePlace tile_place(int i) { return {4 * (i / 16 % 8) + i % 4, 4 * (i / 128) + i / 4 % 4}; }

/// What few pixels exceed; but where few see anything move, a share of what they see.
float typical(std::vector<float>& spreads) {
  const auto few = spreads.begin() + static_cast<std::ptrdiff_t>(spreads.size() * 85 / 100);
  std::nth_element(spreads.begin(), few, spreads.end());
  return std::max(*few, *std::max_element(spreads.begin(), spreads.end()) / 3.0f);
}

}  // namespace

void FilmMotion::look_for_spreads(const Scene& scene, const Exposure& exposure,
                                  const std::vector<SplatPackets>& sets, const SplatRow& standing,
                                  const SplatMath& math, const CellGrid& grid) {
  for (const double share : {0.0, 0.5, 1.0})
    draw(scene, gather(scene, sets, exposure.at(share), standing, math), math, grid, Look::spreads);
}

void FilmMotion::look_for_ways(const Scene& scene, const std::vector<SplatPackets>& sets, double frame,
                               const SplatRow& standing, const SplatMath& math, const CellGrid& grid) {
  const std::vector<CoarseSplat> splats = gather(scene, sets, frame, standing, math);
  for (const Look what : {Look::first_order, Look::last_order, Look::ways})
    draw(scene, splats, math, grid, what);
  spread_ways(grid.film);
  near_jumps_of_ =
      near_jumps(near_splats_, colors_, way_columns_, pitch_px, scene.splats, splat_rule(scene).linear, grid);
}

/// All splats at a frame, on a film of one of every few pixels.
std::vector<FilmMotion::CoarseSplat> FilmMotion::gather(const Scene& scene,
                                                        const std::vector<SplatPackets>& sets, double frame,
                                                        const SplatRow& standing,
                                                        const SplatMath& math) const {
  std::vector<CoarseSplat> splats;
  const auto add = [&](PlacedSplat splat, const Path& path, bool disc) {
    // Pixel i of the coarse film is the fine one's middle one of its i-th few.
    constexpr int middle = pitch_px / 2;
    const int x_first = (std::max(0, splat.x_first - middle) + pitch_px - 1) / pitch_px;
    const int y_first = (std::max(0, splat.y_first - middle) + pitch_px - 1) / pitch_px;
    const int x_last = splat.x_last < middle ? -1 : (splat.x_last - middle) / pitch_px;
    const int y_last = splat.y_last < middle ? -1 : (splat.y_last - middle) / pitch_px;
    if (x_first > x_last || y_first > y_last) return;
    constexpr float pitch = pitch_px;
    const auto own = static_cast<float>(in_deviations(splat, 1.0, 0.0));
    splat.center_x = (static_cast<float>(middle) - splat.pixel_x + splat.center_x) / pitch;
    splat.center_y = (static_cast<float>(middle) - splat.pixel_y + splat.center_y) / pitch;
    splat.pixel_x = splat.pixel_y = 0.0f;
    splat.ux *= pitch, splat.uy *= pitch, splat.vy *= pitch;
    if (disc) splat.gx *= pitch, splat.gy *= pitch;
    splat.x_first = static_cast<std::uint16_t>(x_first), splat.x_last = static_cast<std::uint16_t>(x_last);
    splat.y_first = static_cast<std::uint16_t>(y_first), splat.y_last = static_cast<std::uint16_t>(y_last);
    splats.push_back({splat, path, own, disc});
  };
  for (std::size_t i = 0; i < sets.size(); ++i) {
    if (!sets[i].moves) continue;
    const SplatPose pose(scene, sets[i], frame);
    PosedPacket memory;
    for (std::size_t p = 0; p < sets[i].count; ++p) {
      const PlacedLanes at =
          placed_lanes(math, fields_at(sets[i], p, pose, memory), pose.view, pose.origin(sets[i], p));
      for (std::uint32_t rest = at.seen; rest != 0; rest &= rest - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
        add(at.lanes[lane], of_sets_[i][p * static_cast<std::size_t>(packet_size) + lane],
            sets[i].object->splats.flat);
      }
    }
  }
  for (std::size_t i = 0; i < standing.size(); ++i) add(standing.splats()[i], {}, standing.is_disc(i));
  return splats;
}

/// With what splats do in place of colours.
void FilmMotion::draw(const Scene& scene, const std::vector<CoarseSplat>& seen, const SplatMath& math,
                      const CellGrid& grid, Look what) {
  std::vector<PlacedSplat> splats;
  std::vector<float> fineness;
  splats.reserve(seen.size());
  for (const CoarseSplat& from : seen) {
    PlacedSplat splat = from.splat;
    const Way& way = from.path.way;
    if (what == Look::spreads) {
      splat.red = way.spread * way.spread + from.path.fade * from.path.fade;
    } else if (what == Look::ways) {
      // Fine splats have the frequencies that matter: they count by their inverse variances.
      const float length = std::hypot(way.x, way.y);
      const float per_px = length > 0.0f ? way.spread / length : from.per_px, weight = per_px * per_px;
      splat.red = weight * length, splat.green = weight * way.x, splat.blue = weight * way.y;
      fineness.push_back(weight);
    } else {
      const float depth = what == Look::first_order ? from.path.first_depth : from.path.last_depth;
      if (depth > 0.0f) splat.depth = depth;
    }
    splats.push_back(splat);
  }
  std::vector<std::uint32_t> order = by_depth(splats);
  for (std::uint32_t& index : order)
    if (seen[index].disc) index |= disc_flag;
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
  if (what == Look::first_order) {
    colors_.assign(3 * columns * rows * static_cast<std::size_t>(tile_floats), 0.0f);
    jumps_of_.assign(grid.size(), 0.0);
  }
  if (what == Look::ways) ways_.assign(columns * rows * static_cast<std::size_t>(tile_floats), Way{});
  parallel_for_each_index(columns * rows, [&](std::size_t t) {
    const int x = static_cast<int>(t % columns) * tile_px, y = static_cast<int>(t / columns) * tile_px;
    const auto tile = std::make_unique<SplatTile>();
    math.clear(*tile);
    math.draw({{splats.data(), splats.data()}, lists[t].data(), lists[t].size()}, x, y, rule, *tile);
    if (what == Look::ways)
      take_ways(*tile, x, y);
    else if (what == Look::spreads)
      take_spreads(*tile, x, y, grid);
    else
      take_order(*tile, x, y, grid, rule.linear, what);
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

/// Splats in the order of depth that they have first, and then in that which they have last: what differs is
/// all that a pixel jumps by, of which N instants miss a twelfth of the square over N².
void FilmMotion::take_order(const SplatTile& tile, int x, int y, const CellGrid& grid, bool linear,
                            Look which) {
  constexpr double pixels = cell_px / pitch_px * (cell_px / pitch_px);
  for (int i = 0; i < tile_floats; ++i) {
    const TilePlace at = tile_place(i);
    const SplatBlock& block = tile.blocks[i / 16];
    const std::size_t place =
        static_cast<std::size_t>(y + at.y) * way_columns_ + static_cast<std::size_t>(x + at.x);
    const float* const values[3] = {block.red, block.green, block.blue};
    double squares = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = values[c][i % 16];
      // Near enough to the curve of sRGB.
      const float light = linear ? value : value * std::abs(value);
      float& first = colors_[3 * place + c];
      if (which == Look::first_order)
        first = light;
      else
        squares += std::pow(double{light} - double{first}, 2);
    }
    const auto column = static_cast<std::size_t>((x + at.x) * pitch_px / cell_px),
               row = static_cast<std::size_t>((y + at.y) * pitch_px / cell_px);
    if (squares > 0.0 && column < grid.columns && row < grid.rows)
      jumps_of_[row * grid.columns + column] += squares / (3.0 * 12.0 * pixels);
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

}  // namespace swept
