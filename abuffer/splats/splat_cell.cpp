#include "abuffer/splats/splat_cell.h"

#include <algorithm>
#include <cmath>
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
  rule.linear = model.blending == SplatBlending::linear;
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

SplatSquares CellOfSplats::squares(const Cell& cell) const {
  SplatSquares squares;
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

void SplatPainter::add(const Cell& cell, std::size_t index, const SplatRow& standing, const SplatRow& moving,
                       const InstantWeights& weights, CellOfSplats& sums) {
  merge(index, standing, moving);
  const PlacedSplat* const rows[2] = {standing.splats(), moving.splats()};
  std::size_t counts[tiles_a_cell] = {};
  for (std::vector<std::uint32_t>& list : of_tile_)
    if (list.size() < merged_.size()) list.resize(merged_.size());
  for (const std::uint32_t entry : merged_) {
    const PlacedSplat& splat = rows[entry >> 31][entry & splat_index];
    const auto tile = [](int px) { return (px < 0 ? 0 : px >= cell_px ? cell_px - 1 : px) / tile_px; };
    for (int y = tile(splat.y_first - cell.y); y <= tile(splat.y_last - cell.y); ++y)
      for (int x = tile(splat.x_first - cell.x); x <= tile(splat.x_last - cell.x); ++x) {
        const auto t = static_cast<std::size_t>(y * tiles_a_side + x);
        of_tile_[t][counts[t]++] = entry;
      }
  }
  for (int t = 0; t < tiles_a_cell; ++t) {
    const int x = cell.x + t % tiles_a_side * tile_px, y = cell.y + t / tiles_a_side * tile_px;
    if (x >= cell.x + cell.width || y >= cell.y + cell.height) continue;
    math_.clear(tile_);
    const auto tile = static_cast<std::size_t>(t);
    looks += math_.draw({{rows[0], rows[1]}, of_tile_[tile].data(), counts[tile]}, x, y, rule_, tile_);
    math_.add_instant(tile_, rule_, weights, sums.tiles[t]);
  }
}

}  // namespace swept
