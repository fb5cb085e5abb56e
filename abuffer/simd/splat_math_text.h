// What splat_math.h declares, in terms of the Vector and Mask that were included before. One text for every
// instruction set, as sampled_math_text.h is.
#pragma once

#include <initializer_list>

#include "abuffer/simd/splat_place_text.h"

namespace swept {
namespace {

/// Pixels of a row of blocks and of a column, relative to the tile's first.
struct TilePlaces {
  float x[8][16], y[8][16];

  constexpr TilePlaces() : x(), y() {
    for (int block = 0; block < 8; ++block)
      for (int i = 0; i < 16; ++i) {
        x[block][i] = static_cast<float>(4 * block + i % 4);
        y[block][i] = static_cast<float>(4 * block + i / 4);
      }
  }
};
alignas(64) inline constexpr TilePlaces tile_places;

/// Blocks in a box from which on it pays to ask which of them the ellipse in it touches.
inline constexpr int worth_a_closer_look = 8;

/// 2^x for |x| ≤ 100, by a polynomial of the fraction that is off by 2.6·10⁻⁶ of it at most (Remez).
SWEPT_LANE Vector quick_power_of_two(Vector x) {
  const Vector shifted = x + all(rounder + 127.0f);
  const Vector f = x - (shifted - all(rounder + 127.0f));
  Vector p = all(9.570101908e-3f);
  p = p * f + all(5.591786032e-2f);
  p = p * f + all(2.402474483e-1f);
  p = p * f + all(6.931218147e-1f);
  p = p * f + all(9.999992614e-1f);
  return p * exponent_from_low_bits(shifted);
}

/// The same to 10⁻⁷.
SWEPT_LANE Vector power_of_two(Vector x) {
  const Vector shifted = x + all(rounder + 127.0f);
  const Vector f = x - (shifted - all(rounder + 127.0f));
  Vector p = all(1.327647198e-3f);
  p = p * f + all(9.675541334e-3f);
  p = p * f + all(5.550713274e-2f);
  p = p * f + all(2.402211972e-1f);
  p = p * f + all(6.931469671e-1f);
  p = p * f + all(1.0f);
  return p * exponent_from_low_bits(shifted);
}

/// log₂ of a positive normal number: 2 artanh(t)/ln 2 with t = (m − 1)/(m + 1), |t| ≤ 0.172 (Remez).
SWEPT_LANE Vector log2_of(Vector x) {
  const Vector m = mantissa_of(x), e = exponent_of(x);
  const Mask upper = all(1.41421356f) < m;
  const Vector n = choose(upper, m * all(0.5f), m), whole = choose(upper, e + all(1.0f), e);
  const Vector t = (n - all(1.0f)) / (n + all(1.0f)), tt = t * t;
  Vector p = all(0.43176250f);
  p = p * tt + all(0.57671340f);
  p = p * tt + all(0.96179886f);
  p = p * tt + all(2.88539008f);
  return whole + t * p;
}

/// IEC 61966-2-1, continued oddly below 0 and by its formula above 1.
SWEPT_LANE Vector decoded(Vector s) {
  const Vector v = magnitude(s);
  const Vector power =
      power_of_two(smaller(all(2.4f) * log2_of((v + all(0.055f)) * all(0.94786730f)), all(100.0f)));
  const Vector light = choose(v <= all(0.04045f), v * all(0.077399381f), power);
  return choose(s < all(0.0f), all(0.0f) - light, light);
}

/// The inverse of decoded().
SWEPT_LANE Vector encoded(Vector light) {
  const Vector v = magnitude(light);
  const Vector power = all(1.055f) * power_of_two(all(0.41666667f) * log2_of(larger(v, all(1e-30f))));
  const Vector value = choose(v <= all(0.0031308f), v * all(12.92f), power - all(0.055f));
  return choose(light < all(0.0f), all(0.0f) - value, value);
}

/// Bits first … last of eight.
inline std::uint64_t eight_bits(int first, int last) { return (2u << last) - (1u << first); }

/// Which of a tile's blocks a splat's box touches.
inline std::uint64_t blocks_of(const PlacedSplat& splat, int x, int y) {
  const auto block = [](int px) { return (px < 0 ? 0 : px > tile_px - 1 ? tile_px - 1 : px) / 4; };
  const std::uint64_t row = eight_bits(block(splat.x_first - x), block(splat.x_last - x));
  const int first = block(splat.y_first - y), last = block(splat.y_last - y);
  // One bit for each row of blocks, eight apart.
  const std::uint64_t rows = (0x0101010101010101u >> (8 * (7 - last))) & (~std::uint64_t{0} << (8 * first));
  return row * rows;
}

inline constexpr float band_first[16] = {0, 4, 8, 12, 16, 20, 24, 28, 0, 4, 8, 12, 16, 20, 24, 28};
inline constexpr float band_side[16] = {1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1, -1, -1};

/// Which of them an ellipse touches: rows of blocks from the right and from the left, where u² + v² ≤ limit.
/// Along the rim dx = −uy/ux · dy ± √(limit − v²)/ux, which has one maximum and falls off to both sides.
inline std::uint64_t blocks_of_ellipse(const PlacedSplat& s, int x, int y, std::uint64_t box) {
  // A little more than the rounding of what follows.
  const float limit = s.limit() * 1.0001f + 1e-4f;
  const float vy2 = s.vy * s.vy, inverse = 1.0f / s.ux, tilt = s.uy * inverse;
  const float top = s.uy * __builtin_sqrtf(limit / (vy2 * (s.uy * s.uy + vy2)));
  const float from_x = (s.pixel_x - static_cast<float>(x)) - s.center_x;
  const float from_y = (static_cast<float>(y) - s.pixel_y) + s.center_y;
  alignas(64) float block[16];
  for (int i = 0; i < 16; i += vector_lanes) {
    const Vector side = load(band_side + i);
    const Vector first = load(band_first + i) + all(from_y), last = first + all(3.0f);
    const Vector dy = smaller(larger(all(0.0f) - side * all(top), first), last);
    const Vector inside = all(limit) - all(vy2) * (dy * dy);
    const Vector dx = side * (root(larger(inside, all(0.0f))) * all(inverse)) - all(tilt) * dy;
    // Of pixels, their block, and beyond the rows that are not met.
    const Vector px = side * floor_of(side * (dx + all(from_x)) + all(1e-3f));
    const Vector at = floor_of(smaller(larger(px, all(-4.0f)), all(tile_px)) * all(0.25f));
    store(choose(all(0.0f) <= inside, at, side * all(-1.0f) + all(-1.0f) * side), block + i);
  }
  std::uint64_t blocks = 0;
  for (int row = 0; row < 8; ++row) {
    const int right = block[row] > 7.0f ? 7 : static_cast<int>(block[row]);
    const int left = block[row + 8] < 0.0f ? 0 : static_cast<int>(block[row + 8]);
    if (left <= right) blocks |= eight_bits(left, right) << (8 * row);
  }
  return blocks & box;
}

/// One splat's numbers, in all lanes.
struct Brush {
  Vector x, y, ux, uy, vy, opacity, red, green, blue, depth, gx, gy;

  /// For a tile whose first pixel is (x, y).
  Brush(const PlacedSplat& s, int of_x, int of_y)
      : x(all((static_cast<float>(of_x) - s.pixel_x) + s.center_x)),
        y(all((static_cast<float>(of_y) - s.pixel_y) + s.center_y)),
        ux(all(s.ux)),
        uy(all(s.uy)),
        vy(all(s.vy)),
        opacity(all(s.opacity)),
        red(all(s.red)),
        green(all(s.green)),
        blue(all(s.blue)),
        depth(all(s.depth)),
        gx(all(s.gx)),
        gy(all(s.gy)) {}
};

/// Blends into a block of the tile. Returns whether a pixel has all its light taken by that.
template <bool flat, bool ranged>
SWEPT_LANE bool draw_block(const Brush& brush, const SplatRule& rule, const SplatRange* range, int block,
                           SplatBlock& to) {
  std::uint32_t ended = 0;
  for (int part = 0; part < vector_parts; ++part) {
    const int i = part * vector_lanes;
    const Vector dx = brush.x + load(tile_places.x[block % 8] + i);
    const Vector dy = brush.y + load(tile_places.y[block / 8] + i);
    Vector u = brush.ux * dx + brush.uy * dy, v = brush.vy * dy;
    Vector square;
    if constexpr (flat) {
      const Vector inverse = all(1.0f) / ((all(1.0f) - brush.gx * dx) - brush.gy * dy);
      u = u * inverse;
      v = v * inverse;
      const Vector screen = all(2.0f * half_log2_e) * (dx * dx + dy * dy);
      const Mask met = all(rule.near) < brush.depth * inverse;
      square = choose(met, smaller(u * u + v * v, screen), screen);
    } else {
      square = u * u + v * v;
    }
    const Vector gauss = quick_power_of_two(all(0.0f) - smaller(square, all(100.0f)));
    const Vector alpha = smaller(brush.opacity * gauss, all(rule.most_alpha));
    const Vector through = load(to.light + i);
    Mask counts = (all(rule.least_alpha) <= alpha) & (all(0.0f) < through);
    if constexpr (ranged)
      counts = counts & (load(range->from + 16 * block + i) <= brush.depth) &
               (brush.depth < load(range->to + 16 * block + i));
    if (vector_lanes > 1 && bits(counts) == 0) continue;
    const Vector weight = through * alpha, left = through - weight;
    const Mask drawn = counts & (all(rule.least_light) <= left);
    const Mask ends = without(counts, drawn);
    ended |= bits(ends);
    store(choose(drawn, left, choose(ends, all(0.0f) - through, through)), to.light + i);
    const Vector w = only(drawn, weight);
    const auto add = [&](float* sums, Vector what) { store(load(sums + i) + w * what, sums + i); };
    add(to.red, brush.red);
    add(to.green, brush.green);
    add(to.blue, brush.blue);
    add(to.depth, brush.depth);
  }
  return ended != 0;
}

/// Blends into blocks of the tile. Returns those in which no pixel has light left, among those that lost
/// some.
template <bool flat, bool ranged>
SWEPT_LANE std::uint64_t draw_blocks(const Brush& brush, const SplatRule& rule, const SplatRange* range,
                                     std::uint64_t blocks, SplatTile& tile) {
  std::uint64_t dark = 0;
  for (; blocks != 0; blocks &= blocks - 1) {
    const int block = __builtin_ctzll(blocks);
    SplatBlock& to = tile.blocks[block];
    if (!draw_block<flat, ranged>(brush, rule, range, block, to)) continue;
    std::uint32_t open = 0;
    for (int k = 0; k < 16; k += vector_lanes) open |= bits(all(0.0f) < load(to.light + k));
    if (open == 0) dark |= std::uint64_t{1} << block;
  }
  return dark;
}

template <bool ranged>
SWEPT_LANE std::size_t draw_list(const SplatList& list, int x, int y, const SplatRule& given,
                                 const SplatRange* range, SplatTile& tile) {
  std::size_t looks = 0;
  std::uint64_t lit = ~std::uint64_t{0};
  const SplatRule rule = given;
  for (std::size_t i = 0; i < list.count && lit != 0; ++i) {
    const std::uint32_t index = list.index[i];
    const PlacedSplat& splat = list.rows[index >> 31][index & splat_index];
    std::uint64_t blocks = blocks_of(splat, x, y) & lit;
    const bool disc = index & disc_flag;
    if (!disc && __builtin_popcountll(blocks) >= worth_a_closer_look)
      blocks = blocks_of_ellipse(splat, x, y, blocks);
    if (blocks == 0) continue;
    looks += static_cast<std::size_t>(__builtin_popcountll(blocks));
    const Brush brush(splat, x, y);
    lit &= ~(disc ? draw_blocks<true, ranged>(brush, rule, range, blocks, tile)
                  : draw_blocks<false, ranged>(brush, rule, range, blocks, tile));
  }
  return looks;
}

inline std::size_t draw_text(const SplatList& list, int x, int y, const SplatRule& rule, SplatTile& tile) {
  return draw_list<false>(list, x, y, rule, nullptr, tile);
}

inline std::size_t draw_between_text(const SplatList& list, int x, int y, const SplatRule& rule,
                                     const SplatRange& range, SplatTile& tile) {
  return draw_list<true>(list, x, y, rule, &range, tile);
}

/// A run of splats covers what is behind it in the values it was trained in; surfaces blend in light.
inline void fold_text(const SplatTile* runs, const SurfaceLayer* surfaces, std::size_t count,
                      const SplatRule& rule, SplatTile& seen) {
  const Vector one = all(1.0f);
  for (int i = 0; i < tile_floats; i += vector_lanes) {
    const int lane = i % 16;
    Vector behind[3] = {all(rule.background[0]), all(rule.background[1]), all(rule.background[2])};
    for (std::size_t k = count + 1; k-- > 0;) {
      const SplatBlock& run = runs[k].blocks[i / 16];
      const Vector light = magnitude(load(run.light + lane));
      const Mask none = one <= light;
      const float* const of_run[3] = {run.red, run.green, run.blue};
      for (int c = 0; c < 3; ++c) {
        const Vector own = load(of_run[c] + lane);
        const Vector over = rule.linear ? own + light * behind[c] : decoded(own + light * encoded(behind[c]));
        behind[c] = choose(none, behind[c], over);
      }
      if (k == 0) break;
      const SurfaceLayer& surface = surfaces[k - 1];
      const Vector through = one - load(surface.alpha + i);
      const float* const of_surface[3] = {surface.red, surface.green, surface.blue};
      for (int c = 0; c < 3; ++c) behind[c] = load(of_surface[c] + i) + through * behind[c];
    }
    Vector through = one, depth = all(0.0f);
    for (std::size_t k = 0; k <= count; ++k) {
      const SplatBlock& run = runs[k].blocks[i / 16];
      depth = depth + through * load(run.depth + lane);
      through = through * magnitude(load(run.light + lane));
      if (k == count) break;
      const Vector alpha = load(surfaces[k].alpha + i);
      // Where a pixel has fewer surfaces, the depth of those it lacks is infinite.
      depth = depth + through * only(all(0.0f) < alpha, alpha * load(surfaces[k].depth + i));
      through = through * (one - alpha);
    }
    SplatBlock& to = seen.blocks[i / 16];
    store(behind[0], to.red + lane);
    store(behind[1], to.green + lane);
    store(behind[2], to.blue + lane);
    store(depth, to.depth + lane);
    store(through, to.light + lane);
  }
}

inline void clear_tile_text(SplatTile& tile) {
  for (SplatBlock& block : tile.blocks)
    for (int i = 0; i < 16; i += vector_lanes) {
      store(all(1.0f), block.light + i);
      for (float* sums : {block.red, block.green, block.blue, block.depth}) store(all(0.0f), sums + i);
    }
}

inline void add_tile_text(const SplatTile& tile, const SplatRule& rule, const InstantWeights& weights,
                          SplatSums& sums) {
  const Vector w = all(weights.weight), s = all(weights.alternating);
  float* const quarter = weights.odd != 0.0f ? sums.odd : sums.even;
  const Vector q = all(weights.odd != 0.0f ? weights.odd : weights.even);
  for (int i = 0; i < tile_floats; i += vector_lanes) {
    const SplatBlock& block = tile.blocks[i / 16];
    const int lane = i % 16;
    const auto add = [&](Vector what, float* sum) { store(load(sum + i) + what, sum + i); };
    const Vector light = magnitude(load(block.light + lane));
    const float* const of_block[3] = {block.red, block.green, block.blue};
    Vector color[3];
    for (int c = 0; c < 3; ++c)
      color[c] = rule.linear ? load(of_block[c] + lane) + light * all(rule.background[c])
                             : decoded(load(of_block[c] + lane) + light * all(rule.encoded[c]));
    add(w * color[0], sums.red);
    add(w * color[1], sums.green);
    add(w * color[2], sums.blue);
    add(w * (all(1.0f) - light), sums.alpha);
    add(w * load(block.depth + lane), sums.depth);
    if (weights.alternating == 0.0f) continue;
    add(s * color[0], sums.alternating_red);
    add(s * color[1], sums.alternating_green);
    add(s * color[2], sums.alternating_blue);
    add(q * ((color[0] + color[1]) + color[2]), quarter);
  }
}

}  // namespace
}  // namespace swept

/// Defines what splat_math.cpp lists.
#define SWEPT_DEFINE_SPLAT_MATH(symbol, name)                                         \
  namespace swept {                                                                   \
  extern const SplatMath symbol;                                                      \
  const SplatMath symbol{name,      place_text,      draw_text,    draw_between_text, \
                         fold_text, clear_tile_text, add_tile_text};                  \
  }
