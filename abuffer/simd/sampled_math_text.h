// What sampled_math.h declares, in terms of the Vector and Mask that were included before. One text for every
// instruction set; a source that includes it includes nothing else with inline functions, for these would be
// compiled for that instruction set too and might be linked where it is missing.
#pragma once

#include <initializer_list>

#include "abuffer/simd/sampled_lanes_text.h"
#include "abuffer/simd/sampled_place_text.h"

namespace swept {
namespace {

inline constexpr float lanes_x_4x4[16] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
inline constexpr float lanes_y_4x4[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
inline constexpr float lanes_x_8x2[16] = {0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7};
inline constexpr float lanes_y_8x2[16] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};

struct Block4x4 {
  static constexpr int width = 4, height = 4;
  static constexpr const float* lanes_x = lanes_x_4x4;
  static constexpr const float* lanes_y = lanes_y_4x4;
  static Vector load_from(const float* from, int part) { return load_4x4(from, cell_pitch, part); }
  static void store_to(Vector a, float* to, int part) { store_4x4(a, to, cell_pitch, part); }
};
struct Block8x2 {
  static constexpr int width = 8, height = 2;
  static constexpr const float* lanes_x = lanes_x_8x2;
  static constexpr const float* lanes_y = lanes_y_8x2;
  static Vector load_from(const float* from, int part) { return load_8x2(from, cell_pitch, part); }
  static void store_to(Vector a, float* to, int part) { store_8x2(a, to, cell_pitch, part); }
};

/// Pixels of a cell, relative to it.
struct Span {
  int x_begin, x_end, y_begin, y_end;

  [[nodiscard]] bool empty() const { return x_begin >= x_end || y_begin >= y_end; }
};

inline int clamped(float value, int low, int high) {
  return value <= static_cast<float>(low)    ? low
         : value >= static_cast<float>(high) ? high
                                             : static_cast<int>(value);
}

inline Span span_of(const PlacedPacket& placed, int lane, int x_film, int y_film, int width, int height) {
  const float x = static_cast<float>(x_film), y = static_cast<float>(y_film);
  return {clamped(placed.x_begin[lane] - x, 0, width), clamped(placed.x_end[lane] - x, 0, width),
          clamped(placed.y_begin[lane] - y, 0, height), clamped(placed.y_end[lane] - y, 0, height)};
}

/// Whether something at `nearest` and beyond could be part of a front surface in these pixels.
inline bool may_be_in_front(const CellBuffers& cell, const Span& span, float nearest) {
  for (int y = span.y_begin / patch_px; y <= (span.y_end - 1) / patch_px; ++y)
    for (int x = span.x_begin / patch_px; x <= (span.x_end - 1) / patch_px; ++x)
      if (nearest <= cell.patch_limit[y * cell_patches + x]) return true;
  return false;
}

/// Remembers that something is drawn in these pixels.
inline void touch(CellBuffers& cell, const Span& span) {
  if (cell.touched == all_strips) return;
  const std::uint32_t columns = (2u << (span.x_end - 1) / strip_px) - (1u << span.x_begin / strip_px);
  for (int y = span.y_begin / patch_px; y <= (span.y_end - 1) / patch_px; ++y)
    cell.touched |= columns << y * cell_strips;
}

/// Calls visit(x, y) for the first pixels of the vectors of these strips.
template <class Visit>
SWEPT_LANE void for_each_vector(std::uint32_t strips, int height, const Visit& visit) {
  if (strips == all_strips) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < cell_px; x += vector_lanes) visit(x, y);
    return;
  }
  for (; strips != 0; strips &= strips - 1) {
    const int strip = __builtin_ctz(strips);
    const int x_begin = strip % cell_strips * strip_px, y_begin = strip / cell_strips * patch_px;
    const int y_end = y_begin + patch_px < height ? y_begin + patch_px : height;
    for (int y = y_begin; y < y_end; ++y)
      for (int x = x_begin; x < x_begin + strip_px; x += vector_lanes) visit(x, y);
  }
}

/// Whether light gets through the front surfaces somewhere near these pixels.
inline bool light_reaches(const CellBuffers& cell, const Span& span) {
  for (int y = span.y_begin / patch_px; y <= (span.y_end - 1) / patch_px; ++y)
    for (int x = span.x_begin / patch_px; x <= (span.x_end - 1) / patch_px; ++x)
      if (cell.patch_leaks[y * cell_patches + x]) return true;
  return false;
}

/// One disc's numbers, in all lanes.
struct Disc {
  Vector center_x, center_y, ux, uy, vy, gx, gy, depth;

  Disc(const PlacedPacket& placed, int lane)
      : center_x(all(placed.center_x[lane])),
        center_y(all(placed.center_y[lane])),
        ux(all(placed.ux[lane])),
        uy(all(placed.uy[lane])),
        vy(all(placed.vy[lane])),
        gx(all(placed.gx[lane])),
        gy(all(placed.gy[lane])),
        depth(all(placed.depth[lane])) {}
};

struct Met {
  Vector radius_squared, depth;
  Mask inside;
};

/// `x` and `y` are whole pixels from the disc's own.
template <bool parallel>
SWEPT_LANE Met meet(const Disc& disc, Vector x, Vector y, Vector near) {
  const Vector dx = x + disc.center_x, dy = y + disc.center_y;
  Met met;
  if (parallel) {
    const Vector u = disc.ux * dx + disc.uy * dy, v = disc.vy * dy;
    met.radius_squared = u * u + v * v;
    met.depth = disc.depth + (disc.gx * dx + disc.gy * dy);
  } else {
    const Vector w = (all(1.0f) - disc.gx * dx) - disc.gy * dy;
    const Vector inverse = all(1.0f) / w;
    const Vector u = (disc.ux * dx + disc.uy * dy) * inverse, v = (disc.vy * dy) * inverse;
    met.radius_squared = u * u + v * v;
    met.depth = disc.depth * inverse;
  }
  met.inside = (met.radius_squared <= all(1.0f)) & (near <= met.depth);
  return met;
}

/// Calls visit(first pixel of a block, x, y, part) for all blocks of a span, x and y being whole pixels from
/// the disc.
template <class Block, class Visit>
SWEPT_LANE void for_each_block(const Span& span, float from_disc_x, float from_disc_y, const Visit& visit) {
  for (int y = span.y_begin; y < span.y_end; y += Block::height)
    for (int x = span.x_begin; x < span.x_end; x += Block::width)
      for (int part = 0; part < vector_parts; ++part)
        visit(y * cell_pitch + x,
              all(from_disc_x + static_cast<float>(x)) + load(Block::lanes_x + part * vector_lanes),
              all(from_disc_y + static_cast<float>(y)) + load(Block::lanes_y + part * vector_lanes), part);
}

/// Whichever shape needs fewer blocks; it changes no bit.
inline bool prefers_4x4(const Span& span) {
  const int width = span.x_end - span.x_begin, height = span.y_end - span.y_begin;
  return ((width + 3) / 4) * ((height + 3) / 4) < ((width + 7) / 8) * ((height + 1) / 2);
}

/// Calls one(lane, span) for the lanes whose discs may show in front.
template <class One>
SWEPT_LANE void for_each_lane(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film,
                              int width, int height, const One& one) {
  for (; lanes != 0; lanes &= lanes - 1) {
    const int lane = __builtin_ctz(lanes);
    const Span span = span_of(placed, lane, x_film, y_film, width, height);
    if (!span.empty()) one(lane, span);
  }
}

template <bool truth>
struct Known {
  static constexpr bool value = truth;
};

/// Calls run(sides, parallel), known to the compiler.
template <class Run>
SWEPT_LANE void by_rule(const SurfaceRule& rule, const Run& run) {
  if (rule.orthographic)
    rule.sides ? run(Known<true>{}, Known<true>{}) : run(Known<false>{}, Known<true>{});
  else
    rule.sides ? run(Known<true>{}, Known<false>{}) : run(Known<false>{}, Known<false>{});
}

template <class Block, bool sides, bool parallel>
SWEPT_LANE void bring_disc_to_front(const PlacedPacket& placed, int lane, const Span& span, int x_film,
                                    int y_film, float near, CellBuffers& cell) {
  const Disc disc(placed, lane);
  const Vector tolerance = all(placed.tolerance[lane]), near_plane = all(near);
  const Vector own = all(sides ? side_number(placed, lane) : 0.0f);
  for_each_block<Block>(
      span, static_cast<float>(x_film) - placed.pixel_x[lane],
      static_cast<float>(y_film) - placed.pixel_y[lane], [&](int pixel, Vector x, Vector y, int part) {
        const Met met = meet<parallel>(disc, x, y, near_plane);
        const Vector front = Block::load_from(cell.front + pixel, part);
        const Vector limit = Block::load_from(cell.limit + pixel, part);
        Mask nearer = met.inside & (met.depth < front), equal = met.inside & (met.depth == front);
        if (vector_lanes > 1 && bits(nearer | equal) == 0) return;
        if (sides) {
          const Vector side = Block::load_from(cell.side + pixel, part);
          nearer = nearer | (equal & (side < own));
          equal = equal & (side == own);
          Block::store_to(choose(nearer, own, side), cell.side + pixel, part);
        }
        const Vector reached = met.depth + tolerance;
        Block::store_to(choose(nearer, met.depth, front), cell.front + pixel, part);
        Block::store_to(choose(nearer, reached, choose(equal, larger(limit, reached), limit)),
                        cell.limit + pixel, part);
      });
}

template <bool sides, bool parallel>
SWEPT_LANE void bring_discs_to_front(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film,
                                     int width, int height, const SurfaceRule& rule, CellBuffers& cell) {
  for_each_lane(placed, lanes, x_film, y_film, width, height, [&](int lane, const Span& span) {
    if (!may_be_in_front(cell, span, placed.nearest[lane])) return;
    touch(cell, span);
    if (prefers_4x4(span))
      bring_disc_to_front<Block4x4, sides, parallel>(placed, lane, span, x_film, y_film, rule.near, cell);
    else
      bring_disc_to_front<Block8x2, sides, parallel>(placed, lane, span, x_film, y_film, rule.near, cell);
  });
}

inline void bring_to_front_text(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film,
                                int width, int height, const SurfaceRule& rule, CellBuffers& cell) {
  by_rule(rule, [&](auto sides, auto parallel) {
    bring_discs_to_front<sides.value, parallel.value>(placed, lanes, x_film, y_film, width, height, rule,
                                                      cell);
  });
}

template <class Block, bool sides, bool parallel>
SWEPT_LANE void add_disc_to_front(const PlacedPacket& placed, int lane, const Span& span, int x_film,
                                  int y_film, const SurfaceRule& rule, CellBuffers& cell) {
  const Disc disc(placed, lane);
  const Vector near_plane = all(rule.near), sharpness = all(-rule.delta), peak = all(placed.peak[lane]);
  const Vector red = all(placed.red[lane]), green = all(placed.green[lane]), blue = all(placed.blue[lane]);
  const Vector alpha = all(placed.alpha[lane]), own = all(sides ? side_number(placed, lane) : 0.0f);
  for_each_block<Block>(
      span, static_cast<float>(x_film) - placed.pixel_x[lane],
      static_cast<float>(y_film) - placed.pixel_y[lane], [&](int pixel, Vector x, Vector y, int part) {
        const Met met = meet<parallel>(disc, x, y, near_plane);
        Mask counts = met.inside & (met.depth <= Block::load_from(cell.limit + pixel, part));
        if (sides) counts = counts & (all(0.0f) <= own * Block::load_from(cell.side + pixel, part));
        if (vector_lanes > 1 && bits(counts) == 0) return;
        const Vector rho = only(counts, peak * exp_of(sharpness * smaller(met.radius_squared, all(1.0f))));
        const auto add = [&](float* sums, Vector what) {
          Block::store_to(Block::load_from(sums + pixel, part) + what, sums + pixel, part);
        };
        add(cell.weight, rho);
        add(cell.red, rho * red);
        add(cell.green, rho * green);
        add(cell.blue, rho * blue);
        add(cell.alpha, rho * alpha);
        add(cell.depth, only(counts, rho * met.depth));
      });
}

template <bool sides, bool parallel>
SWEPT_LANE void add_discs_to_front(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film,
                                   int width, int height, const SurfaceRule& rule, CellBuffers& cell) {
  for_each_lane(placed, lanes, x_film, y_film, width, height, [&](int lane, const Span& span) {
    if (!may_be_in_front(cell, span, placed.nearest[lane])) return;
    if (prefers_4x4(span))
      add_disc_to_front<Block4x4, sides, parallel>(placed, lane, span, x_film, y_film, rule, cell);
    else
      add_disc_to_front<Block8x2, sides, parallel>(placed, lane, span, x_film, y_film, rule, cell);
  });
}

inline void add_to_front_text(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film,
                              int width, int height, const SurfaceRule& rule, CellBuffers& cell) {
  by_rule(rule, [&](auto sides, auto parallel) {
    add_discs_to_front<sides.value, parallel.value>(placed, lanes, x_film, y_film, width, height, rule, cell);
  });
}

template <bool parallel>
SWEPT_LANE std::size_t find_discs_behind(const PlacedPacket& placed, std::uint32_t lanes,
                                         std::uint32_t first_disc, int x_film, int y_film, int width,
                                         int height, const SurfaceRule& rule, const CellBuffers& cell,
                                         FragmentBehind* out) {
  std::size_t count = 0;
  for_each_lane(placed, lanes, x_film, y_film, width, height, [&](int lane, const Span& span) {
    if (!light_reaches(cell, span)) return;
    const Disc disc(placed, lane);
    const Vector near_plane = all(rule.near), sharpness = all(-rule.delta), peak = all(placed.peak[lane]);
    const Vector own = all(side_number(placed, lane));
    const std::uint32_t index = (first_disc + static_cast<std::uint32_t>(lane)) |
                                (placed.front >> lane & 1u ? disc_front : 0u) |
                                (placed.back >> lane & 1u ? disc_back : 0u);
    for_each_block<Block4x4>(
        span, static_cast<float>(x_film) - placed.pixel_x[lane],
        static_cast<float>(y_film) - placed.pixel_y[lane], [&](int pixel, Vector x, Vector y, int part) {
          const Vector limit = Block4x4::load_from(cell.behind + pixel, part);
          const Mask leaks = limit < all(infinity);
          if (bits(leaks) == 0) return;
          const Met met = meet<parallel>(disc, x, y, near_plane);
          Mask behind = limit < met.depth;
          if (rule.sides)
            behind = behind | (leaks & (own * Block4x4::load_from(cell.side + pixel, part) < all(0.0f)));
          behind = met.inside & behind;
          std::uint32_t found = bits(behind);
          if (found == 0) return;
          alignas(64) float rho[vector_lanes], depth[vector_lanes];
          store(peak * exp_of(sharpness * smaller(met.radius_squared, all(1.0f))), rho);
          store(met.depth, depth);
          for (; found != 0; found &= found - 1) {
            const int i = __builtin_ctz(found), in_block = part * vector_lanes + i;
            out[count++] = {depth[i], rho[i], index,
                            static_cast<std::uint32_t>(pixel + (in_block / 4) * cell_pitch + in_block % 4)};
          }
        });
  });
  return count;
}

inline std::size_t find_behind_text(const PlacedPacket& placed, std::uint32_t lanes, std::uint32_t first_disc,
                                    int x_film, int y_film, int width, int height, const SurfaceRule& rule,
                                    const CellBuffers& cell, FragmentBehind* out) {
  return rule.orthographic ? find_discs_behind<true>(placed, lanes, first_disc, x_film, y_film, width, height,
                                                     rule, cell, out)
                           : find_discs_behind<false>(placed, lanes, first_disc, x_film, y_film, width,
                                                      height, rule, cell, out);
}

inline void clear_text(CellBuffers& cell, int height) {
  const Vector none = all(infinity), zero = all(0.0f);
  // The border may keep what it has.
  for_each_vector(cell.touched, height, [&](int x, int y) {
    const int i = y * cell_pitch + x;
    store(none, cell.front + i);
    store(none, cell.limit + i);
    for (float* sums : {cell.weight, cell.red, cell.green, cell.blue, cell.alpha, cell.depth})
      store(zero, sums + i);
  });
  for (float& limit : cell.patch_limit) limit = infinity;
  cell.touched = 0;
}

inline void measure_patches_text(CellBuffers& cell, int height) {
  for (int patch_y = 0; patch_y < cell_patches; ++patch_y) {
    // Rows that the film does not have hold nothing and hide nothing.
    const int y_end = (patch_y + 1) * patch_px < height ? (patch_y + 1) * patch_px : height;
    float* const limits = cell.patch_limit + patch_y * cell_patches;
    if ((cell.touched >> patch_y * cell_strips & ((1u << cell_strips) - 1u)) == 0) {
      for (int patch_x = 0; patch_x < cell_patches; ++patch_x)
        limits[patch_x] = patch_y * patch_px < height ? infinity : -infinity;
      continue;
    }
    alignas(64) float columns[cell_px];
    for (int x = 0; x < cell_px; x += vector_lanes) {
      Vector most = all(-infinity);
      for (int y = patch_y * patch_px; y < y_end; ++y)
        most = larger(most, load(cell.limit + y * cell_pitch + x));
      store(most, columns + x);
    }
    for (int patch_x = 0; patch_x < cell_patches; ++patch_x) {
      float most = -infinity;
      for (int i = 0; i < patch_px; ++i) {
        const float limit = columns[patch_x * patch_px + i];
        most = limit > most ? limit : most;
      }
      limits[patch_x] = most;
    }
  }
}

inline bool shade_front_text(const SurfaceRule& rule, CellBuffers& cell, int height) {
  const Vector edge = all(rule.edge_weight), one = all(1.0f), least = all(1.17549435e-38f);
  const Vector opaque = all(0x1p-24f);
  std::uint32_t any = 0;
  for (bool& leaks : cell.patch_leaks) leaks = false;
  for_each_vector(cell.touched, height, [&](int x, int y) {
    const int i = y * cell_pitch + x;
    const Vector weight = load(cell.weight + i);
    const Mask weighs = least <= weight;
    const Vector divisor = rule.hard ? weight : larger(weight, edge);
    const Vector inverse = only(weighs, one / divisor);
    const Vector alpha = only(weighs, smaller(load(cell.alpha + i) / divisor, one));
    for (float* color : {cell.red, cell.green, cell.blue}) store(load(color + i) * inverse, color + i);
    store(only(weighs, alpha * (load(cell.depth + i) / weight)), cell.depth + i);
    store(alpha, cell.alpha + i);
    const Vector through = one - alpha;
    store(through, cell.weight + i);
    const Vector limit = load(cell.limit + i);
    const Mask leaks = (opaque < through) & (limit < all(infinity));
    store(choose(leaks, limit, all(infinity)), cell.behind + i);
    if (bits(leaks) == 0) return;
    any = 1;
    for (int patch = x / patch_px; patch <= (x + vector_lanes - 1) / patch_px; ++patch)
      cell.patch_leaks[y / patch_px * cell_patches + patch] = true;
  });
  return any != 0;
}

inline void add_instant_text(const CellBuffers& cell, const InstantWeights& weights,
                             const float background[3], CellSums& sums, int height) {
  const Vector w = all(weights.weight), s = all(weights.alternating), one = all(1.0f);
  float* const quarter = weights.odd != 0.0f ? sums.odd : sums.even;
  const Vector q = all(weights.odd != 0.0f ? weights.odd : weights.even);
  // Where nothing is there is nothing to add but the background, to what the error is estimated from.
  const bool black = background[0] == 0.0f && background[1] == 0.0f && background[2] == 0.0f;
  for_each_vector(
      black || weights.alternating == 0.0f ? cell.touched : all_strips, height, [&](int x, int y) {
        const int i = y * cell_pitch + x;
        const Vector alpha = load(cell.alpha + i), left = one - alpha;
        const auto add = [&](Vector what, float* sum) { store(load(sum + i) + what, sum + i); };
        const Vector red = load(cell.red + i), green = load(cell.green + i), blue = load(cell.blue + i);
        add(w * red, sums.red);
        add(w * green, sums.green);
        add(w * blue, sums.blue);
        add(w * alpha, sums.alpha);
        add(w * load(cell.depth + i), sums.depth);
        if (weights.alternating == 0.0f) return;
        const Vector over_red = red + left * all(background[0]),
                     over_green = green + left * all(background[1]);
        const Vector over_blue = blue + left * all(background[2]);
        add(s * over_red, sums.alternating_red);
        add(s * over_green, sums.alternating_green);
        add(s * over_blue, sums.alternating_blue);
        add(q * ((over_red + over_green) + over_blue), quarter);
      });
}

}  // namespace
}  // namespace swept

/// Defines what sampled_math.cpp lists.
#define SWEPT_DEFINE_SAMPLED_MATH(symbol, name)                                                   \
  namespace swept {                                                                               \
  extern const SampledMath symbol;                                                                \
  const SampledMath symbol{                                                                       \
      name,       place_text,           bring_to_front_text, add_to_front_text, find_behind_text, \
      clear_text, measure_patches_text, shade_front_text,    add_instant_text};                   \
  }
