#include "abuffer/stochastic/choose_traversal.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace swept::stochastic {
namespace {

/// µs. Fitted to 26 pairs of times of one thread: triangles of 2 and 10 px that move by 0 to 300 px, cloth
/// ball, horse and made-up scenes whose paths are parabolas, 16 and 64 samples a pixel.
constexpr double test_cost = 0.027, tile_pixel_cost = 0.025, interval_pixel_cost = 0.004,
                 tile_start_cost = 0.2, straight_tile_cost = 0.065, curved_tile_cost = 0.45,
                 straight_part_cost = 0.05, curved_part_cost = 0.12;

constexpr std::size_t most_looked_at = 256;
/// Of all of them together, and of one.
constexpr int most_tiles = 20000, most_tiles_of_one = 1024;
/// Side of the squares that threads share out, in each of which all parts are looked at.
constexpr int block_px = 16;

double blocks_of(const PixelRange& range, const PixelRange& window) {
  const auto along = [](int first, int last, int origin) {
    return (last - 1 - origin) / block_px - (first - origin) / block_px + 1;
  };
  return static_cast<double>(along(range.x0, range.x1, window.x0)) * along(range.y0, range.y1, window.y0);
}

double area(const PixelRange& range) {
  return range.empty() ? 0.0 : static_cast<double>(range.x1 - range.x0) * (range.y1 - range.y0);
}

template <class Primitive>
double tile_cost(Primitive& primitive, const PixelRange& window, const StochasticOptions& options,
                 int& tiles) {
  const bool straight = primitive.straight();
  const int side = options.tile_px;
  double cost = 0.0;
  for (int p = 0; p < primitive.pieces(); ++p) {
    const PixelRange range = primitive.pixels(primitive.piece(p), window);
    if (range.empty()) continue;
    primitive.begin_tiles(p, range, side, options.bounds);
    const double blocks = blocks_of(range, window);
    const auto floored = [&](int v) { return v - ((v % side) + side) % side; };
    const int x0 = floored(range.x0), y0 = floored(range.y0);
    const int columns = (range.x1 - x0 + side - 1) / side, rows = (range.y1 - y0 + side - 1) / side;
    // Of many, those on a coarser grid stand for the others.
    const int step = std::max(
        1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(columns) * rows / most_tiles_of_one))));
    double looked_at = 0.0, of_tiles = 0.0;
    for (int row = step / 2; row < rows; row += step)
      for (int column = step / 2; column < columns; column += step) {
        const int x = x0 + column * side, y = y0 + row * side;
        ++looked_at;
        of_tiles += straight ? straight_tile_cost : curved_tile_cost;
        const Span span = primitive.tile(x, y);
        if (span.empty()) continue;
        const double pixels = area(meet(range, {x, y, x + side, y + side}));
        of_tiles += pixels * (tile_pixel_cost +
                              test_cost * options.samples * std::clamp(span.end - span.begin, 0.0, 1.0));
      }
    tiles += static_cast<int>(looked_at);
    cost += tile_start_cost * blocks;
    if (looked_at > 0.0) cost += of_tiles * (static_cast<double>(columns) * rows / looked_at);
  }
  return cost;
}

template <class Primitive>
double interval_cost(Primitive& primitive, const PixelRange& all, const PixelRange& window,
                     const StochasticOptions& options, const SampleSource& source) {
  const double bound = primitive.straight() ? straight_part_cost : curved_part_cost;
  const double per_pixel =
      interval_pixel_cost + test_cost * static_cast<double>(options.samples) / options.intervals;
  double cost = bound * options.intervals * blocks_of(all, window);
  const auto cut = [&](int part) {
    const double share = static_cast<double>(part) / options.intervals;
    return Primitive::by_share ? share : double{source.time_of(share)};
  };
  for (int part = 0; part < options.intervals; ++part)
    cost += per_pixel * area(primitive.pixels({cut(part), cut(part + 1)}, window));
  return cost;
}

}  // namespace

TraversalForecast forecast_traversals(const Primitives& primitives, const PixelRange& window,
                                      const StochasticOptions& options, const SampleSource& source) {
  TraversalForecast forecast;
  const std::size_t count = primitives.size();
  std::size_t looked_at = 0;
  int tiles = 0;
  // Far from each other, whatever the order they come in: steps of the golden section of them all.
  for (std::size_t k = 0; k < std::min(count, 4 * most_looked_at); ++k) {
    if (looked_at == most_looked_at || tiles > most_tiles) break;
    const double at = static_cast<double>(k) * 0.6180339887498949;
    const std::size_t i = count <= most_looked_at
                              ? k
                              : std::min(count - 1, static_cast<std::size_t>((at - std::floor(at)) *
                                                                             static_cast<double>(count)));
    primitives.with(i, [&](auto& primitive) {
      const PixelRange all = primitive.pixels({0.0, 1.0}, window);
      if (all.empty()) return;
      ++looked_at;
      forecast.tile += tile_cost(primitive, window, options, tiles);
      forecast.interval += interval_cost(primitive, all, window, options, source);
    });
  }
  if (looked_at > 0) {
    forecast.tile /= static_cast<double>(looked_at);
    forecast.interval /= static_cast<double>(looked_at);
  }
  return forecast;
}

}  // namespace swept::stochastic
