#include "abuffer/splats/splat_cell.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "splat/srgb.h"

namespace swept {
namespace {

constexpr int tiles_a_side = cell_px / tile_px;

/// Where a tile has the pixel (x, y) of it.
constexpr std::size_t place_in_tile(int x, int y) {
  return static_cast<std::size_t>(16 * (y / 4 * (tile_px / 4) + x / 4) + 4 * (y % 4) + x % 4);
}

/// Calls visit(tile, place in it, x, y) for the pixels of a cell that the film has, x and y being the film's.
template <class Visit>
void for_each_pixel(const Cell& cell, const Visit& visit) {
  for (int y = 0; y < cell.height; ++y)
    for (int x = 0; x < cell.width; ++x)
      visit(static_cast<std::size_t>(y / tile_px * tiles_a_side + x / tile_px),
            place_in_tile(x % tile_px, y % tile_px), cell.x + x, cell.y + y);
}

}  // namespace

SplatRule splat_rule(const Scene& scene) {
  const SplatModel& model = scene.splats;
  SplatRule rule{};
  rule.least_alpha = static_cast<float>(model.least_alpha);
  rule.most_alpha = static_cast<float>(model.most_alpha);
  rule.least_light = static_cast<float>(model.least_light);
  rule.near = static_cast<float>(model.near);
  // Without splats everything is light.
  rule.linear = model.blending == SplatBlending::linear ||
                std::all_of(scene.objects.begin(), scene.objects.end(),
                            [](const Object& object) { return object.splats.size() == 0; });
  if (model.blending == SplatBlending::file)
    for (const Object& object : scene.objects)
      if (object.splats.size() > 0) rule.linear = object.splats.colors == SplatColors::linear;
  for (int c = 0; c < 3; ++c) {
    rule.background[c] = scene.background[c];
    const double light = std::abs(double{scene.background[c]});
    const double value = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
    rule.encoded[c] = static_cast<float>(std::copysign(value, double{scene.background[c]}));
  }
  return rule;
}

SampledCell::Squares CellOfSplats::squares(const Cell& cell) const {
  SampledCell::Squares squares;
  for_each_pixel(cell, [&](std::size_t tile, std::size_t i, int, int) {
    const SplatSums& sums = tiles[tile];
    const double red = double{sums.alternating_red[i]}, green = double{sums.alternating_green[i]},
                 blue = double{sums.alternating_blue[i]};
    const double even = double{sums.even[i]}, odd = double{sums.odd[i]};
    squares.alternating += red * red + green * green + blue * blue;
    squares.grey += (red + green + blue) * (red + green + blue);
    squares.quarter += even * even + odd * odd;
  });
  return squares;
}

void CellOfSplats::alternate_from_sums() {
  for (SplatSums& sums : tiles) {
    std::copy(sums.red, sums.red + tile_floats, sums.alternating_red);
    std::copy(sums.green, sums.green + tile_floats, sums.alternating_green);
    std::copy(sums.blue, sums.blue + tile_floats, sums.alternating_blue);
  }
}

void CellOfSplats::store(const Cell& cell, double total, float background_alpha, Image& image) const {
  for_each_pixel(cell, [&](std::size_t tile, std::size_t i, int x, int y) {
    if (x < image.x || x >= image.x + image.width || y < image.y || y >= image.y + image.height) return;
    const std::size_t to = static_cast<std::size_t>(y - image.y) * static_cast<std::size_t>(image.width) +
                           static_cast<std::size_t>(x - image.x);
    const SplatSums& sums = tiles[tile];
    const double alpha = double{sums.alpha[i]} / total;
    image.rgba[4 * to] = static_cast<float>(double{sums.red[i]} / total);
    image.rgba[4 * to + 1] = static_cast<float>(double{sums.green[i]} / total);
    image.rgba[4 * to + 2] = static_cast<float>(double{sums.blue[i]} / total);
    image.rgba[4 * to + 3] = static_cast<float>(alpha + (1.0 - alpha) * double{background_alpha});
    image.depth[to] = alpha > 0.0 ? static_cast<float>(double{sums.depth[i]} / total / alpha)
                                  : std::numeric_limits<float>::infinity();
  });
}

void CellOfSplats::weigh(const InstantWeights& weights) {
  for (SplatSums& sums : tiles)
    for (std::size_t i = 0; i < static_cast<std::size_t>(tile_floats); ++i) {
      sums.alternating_red[i] = weights.alternating * sums.red[i];
      sums.alternating_green[i] = weights.alternating * sums.green[i];
      sums.alternating_blue[i] = weights.alternating * sums.blue[i];
      const float grey = (sums.red[i] + sums.green[i]) + sums.blue[i];
      sums.even[i] = weights.even * grey;
      sums.odd[i] = weights.odd * grey;
    }
}

void CellOfSplats::copy_colors(const Cell& cell, int width, std::vector<float>& rgba) const {
  for_each_pixel(cell, [&](std::size_t tile, std::size_t i, int x, int y) {
    const std::size_t to =
        4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
    rgba[to] = tiles[tile].red[i], rgba[to + 1] = tiles[tile].green[i], rgba[to + 2] = tiles[tile].blue[i];
  });
}

void CellOfSplats::store_error(const Cell& cell, double per_alternating, const Image& image,
                               std::vector<float>& channel) const {
  for_each_pixel(cell, [&](std::size_t tile, std::size_t i, int x, int y) {
    if (x < image.x || x >= image.x + image.width || y < image.y || y >= image.y + image.height) return;
    const SplatSums& sums = tiles[tile];
    const double red = double{sums.alternating_red[i]}, green = double{sums.alternating_green[i]},
                 blue = double{sums.alternating_blue[i]};
    channel[static_cast<std::size_t>(y - image.y) * static_cast<std::size_t>(image.width) +
            static_cast<std::size_t>(x - image.x)] =
        static_cast<float>(std::sqrt(per_alternating * (red * red + green * green + blue * blue) / 3.0));
  });
}

/// Both rows' splats of a cell, nearest first; what stands still first where both are at one depth.
void SplatPainter::merge(std::size_t index, const SplatRow& standing, const SplatRow& moving) {
  const std::span<const std::uint32_t> still = standing.cell(index), others = moving.cell(index);
  merged_.resize(still.size() + others.size());
  if (others.empty()) {
    std::copy(still.begin(), still.end(), merged_.begin());
    return;
  }
  std::size_t s = 0, m = 0;
  for (std::uint32_t& to : merged_) {
    const bool take_still =
        m == others.size() || (s < still.size() && standing.splats()[still[s] & splat_index].depth <=
                                                       moving.splats()[others[m] & splat_index].depth);
    to = take_still ? still[s++] : others[m++] | second_row;
  }
}

/// Lists of the tiles, in the order of the cell's.
void SplatPainter::share_out(const Cell& cell, const PlacedSplat* const (&rows)[2]) {
  for (std::vector<std::uint32_t>& list : of_tile_)
    if (list.size() < merged_.size()) list.resize(merged_.size());
  std::fill(std::begin(counts_), std::end(counts_), std::size_t{0});
  for (const std::uint32_t entry : merged_) {
    const PlacedSplat& splat = rows[entry >> 31][entry & splat_index];
    const auto tile = [](int px) { return (px < 0 ? 0 : px >= cell_px ? cell_px - 1 : px) / tile_px; };
    for (int y = tile(splat.y_first - cell.y); y <= tile(splat.y_last - cell.y); ++y)
      for (int x = tile(splat.x_first - cell.x); x <= tile(splat.x_last - cell.x); ++x) {
        const auto t = static_cast<std::size_t>(y * tiles_a_side + x);
        of_tile_[t][counts_[t]++] = entry;
      }
  }
}

/// The surfaces of a tile's pixels, the nearest ones first. Returns how many there are at most in a pixel.
std::size_t SplatPainter::gather_layers(const std::vector<SampledCell::Surface>& surfaces, int tile) {
  std::size_t layers = 0;
  std::uint32_t counts[tile_floats] = {};
  for (const SampledCell::Surface& surface : surfaces) {
    if (surface.y / tile_px * tiles_a_side + surface.x / tile_px != tile) continue;
    const std::size_t i = place_in_tile(surface.x % tile_px, surface.y % tile_px), k = counts[i]++;
    if (k == layers) {
      if (layers_.size() == layers) layers_.emplace_back();
      SurfaceLayer& fresh = layers_[layers++];
      fresh = {};
      std::fill(std::begin(fresh.depth), std::end(fresh.depth), std::numeric_limits<float>::infinity());
    }
    SurfaceLayer& layer = layers_[k];
    layer.red[i] = surface.rgba[0], layer.green[i] = surface.rgba[1], layer.blue[i] = surface.rgba[2];
    layer.alpha[i] = surface.rgba[3];
    layer.depth[i] = surface.depth;
  }
  return layers;
}

/// Every run of splats between two surfaces by itself, and then all over each other.
void SplatPainter::draw_among_surfaces(const SplatList& list, std::size_t layers, int x, int y) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  // What an opaque surface lets through is less than a float tells from nothing.
  constexpr float opaque = 1.0f - 0x1p-24f;
  if (runs_.size() < layers + 1) runs_.resize(layers + 1);
  SplatRange range;
  const auto depth = [&](std::uint32_t entry) { return list.rows[entry >> 31][entry & splat_index].depth; };
  for (std::size_t k = 0; k <= layers; ++k) {
    float nearest = infinity, farthest = 0.0f;
    for (std::size_t i = 0; i < static_cast<std::size_t>(tile_floats); ++i) {
      range.from[i] = k == 0 ? 0.0f : layers_[k - 1].alpha[i] >= opaque ? infinity : layers_[k - 1].depth[i];
      range.to[i] = k == layers ? infinity : layers_[k].depth[i];
      nearest = std::min(nearest, range.from[i]);
      if (range.from[i] < range.to[i]) farthest = std::max(farthest, range.to[i]);
    }
    math_.clear(runs_[k]);
    const std::uint32_t *const end = list.index + list.count,
                               *first = std::lower_bound(
                                   list.index, end, nearest,
                                   [&](std::uint32_t entry, float z) { return depth(entry) < z; }),
                               *last = std::lower_bound(
                                   first, end, farthest,
                                   [&](std::uint32_t entry, float z) { return depth(entry) < z; });
    looks += math_.draw_between({{list.rows[0], list.rows[1]}, first, static_cast<std::size_t>(last - first)},
                                x, y, rule_, range, runs_[k]);
  }
  math_.fold(runs_.data(), layers_.data(), layers, rule_, tile_);
}

void SplatPainter::add(const Cell& cell, std::size_t index, const SplatRow& standing, const SplatRow& moving,
                       const std::vector<SampledCell::Surface>& surfaces, const InstantWeights& weights,
                       CellOfSplats& sums) {
  merge(index, standing, moving);
  const PlacedSplat* const rows[2] = {standing.splats(), moving.splats()};
  share_out(cell, rows);
  SplatRule folded = rule_;
  folded.linear = true;
  std::fill(std::begin(folded.background), std::end(folded.background), 0.0f);
  for (int t = 0; t < tiles_a_cell; ++t) {
    const int x = cell.x + t % tiles_a_side * tile_px, y = cell.y + t / tiles_a_side * tile_px;
    if (x >= cell.x + cell.width || y >= cell.y + cell.height) continue;
    const auto tile = static_cast<std::size_t>(t);
    const SplatList list{{rows[0], rows[1]}, of_tile_[tile].data(), counts_[tile]};
    const std::size_t layers = surfaces.empty() ? 0 : gather_layers(surfaces, t);
    if (layers == 0) {
      math_.clear(tile_);
      looks += math_.draw(list, x, y, rule_, tile_);
    } else {
      draw_among_surfaces(list, layers, x, y);
    }
    math_.add_instant(tile_, layers == 0 ? rule_ : folded, weights, sums.tiles[t]);
  }
}

}  // namespace swept
