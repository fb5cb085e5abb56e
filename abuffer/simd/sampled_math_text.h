// What sampled_math.h declares, in terms of the Vector and Mask that were included before. One text for every
// instruction set; a source that includes it includes nothing else with inline functions, for these would be
// compiled for that instruction set too and might be linked where it is missing.
#pragma once

#include <initializer_list>

#include "abuffer/simd/sampled_math.h"

namespace swept {
namespace {

#ifndef SWEPT_LANE
#define SWEPT_LANE inline
#endif

constexpr int vector_parts = packet_size / vector_lanes;
constexpr float infinity = __builtin_inff();

/// Adding and subtracting it rounds to whole numbers, halves to even, below 2²².
constexpr float rounder = 12582912.0f;

SWEPT_LANE Vector rounded(Vector a) { return (a + all(rounder)) - all(rounder); }
SWEPT_LANE Vector floor_of(Vector a) {
  const Vector r = rounded(a);
  return r - only(a < r, all(1.0f));
}

/// e^x for x in [−80, 0], within 1 ulp.
SWEPT_LANE Vector exp_of(Vector x) {
  // 2^(n + f), |f| ≤ ½; n + 127 stands in the low bits of the sum and becomes an exponent.
  const Vector t = x * all(1.44269504f);
  const Vector shifted = t + all(rounder + 127.0f);
  const Vector n = shifted - all(rounder + 127.0f);
  // Cody and Waite: the remainder x − n ln 2 in two steps.
  const Vector r = (x - n * all(0.693359375f)) - n * all(-2.12194440e-4f);
  Vector p = all(1.9875691500e-4f);
  p = p * r + all(1.3981999507e-3f);
  p = p * r + all(8.3334519073e-3f);
  p = p * r + all(4.1665795894e-2f);
  p = p * r + all(1.6666665459e-1f);
  p = p * r + all(5.0000001201e-1f);
  p = (p * r) * r + r + all(1.0f);
  return p * exponent_from_low_bits(shifted);
}

struct Triple {
  Vector x, y, z;
};

SWEPT_LANE Vector field(const float* before, const float* after, float blend, int which, int lane) {
  const Vector a = load(before + which * packet_size + lane);
  if (after == nullptr) return a;
  return a + all(blend) * (load(after + which * packet_size + lane) - a);
}

SWEPT_LANE Triple turned(const float* m, const Triple& v) {
  return {all(m[0]) * v.x + all(m[1]) * v.y + all(m[2]) * v.z,
          all(m[3]) * v.x + all(m[4]) * v.y + all(m[5]) * v.z,
          all(m[6]) * v.x + all(m[7]) * v.y + all(m[8]) * v.z};
}

/// The filtered disc of moving_kernel.h without its principal axes, but for the depth tolerance. In units of
/// the centre's depth along z and of pixels across it, Q = [q_u q_v] the projected axes and r the filter's
/// radius:
///   G = QQᵀ + r²I,   |G| = |Q|² + r² tr(QQᵀ) + r⁴,   g = G⁻¹ Q a_z = (|Q| adj(Q)ᵀ a_z + r² Q a_z) / |G|,
/// sums of positive terms where it matters. A ray (dx, dy) px from the centre's meets the plane at depth z/W,
/// W = 1 − g·d, in w = d/W, and wᵀG⁻¹w = u² + v² with u = √(G_yy/|G|) (w_x − G_xy/G_yy w_y), v = w_y/√G_yy.
void place_text(const PacketPoints& points, const ObjectPlace& object, const PacketPlace& packet, int x,
                int y, int width, int height, PlacedPacket& placed) {
  const Vector left = all(static_cast<float>(x)), right = all(static_cast<float>(x + width));
  const Vector top = all(static_cast<float>(y)), bottom = all(static_cast<float>(y + height));
  std::uint32_t seen = 0, general = 0;
  const float filter_squared = object.filter_px * object.filter_px;
  for (int part = 0; part < vector_parts; ++part) {
    const int lane = part * vector_lanes;
    const auto offset = [&](int which) {
      return field(points.offset, points.offset_after, points.blend, which, lane);
    };
    const auto axis = [&](int which) {
      return field(points.axes, points.axes_after, points.blend, which, lane);
    };
    const Triple from_origin = turned(object.linear, {offset(0), offset(1), offset(2)});
    const Triple a = turned(object.linear, {axis(0), axis(1), axis(2)});
    const Triple b = turned(object.linear, {axis(3), axis(4), axis(5)});

    const Vector depth = all(packet.depth) + from_origin.z;
    const Vector inverse = all(1.0f) / depth;
    const Vector across_x = (from_origin.x - all(packet.tangent_x) * from_origin.z) * inverse;
    const Vector across_y = (from_origin.y - all(packet.tangent_y) * from_origin.z) * inverse;
    const Vector tangent_x = all(packet.tangent_x) + across_x, tangent_y = all(packet.tangent_y) + across_y;
    const Vector from_pixel_x = all(packet.fraction_x) + all(object.focal_px) * across_x;
    const Vector from_pixel_y = all(packet.fraction_y) + all(object.focal_px) * across_y;
    const Vector whole_x = rounded(from_pixel_x), whole_y = rounded(from_pixel_y);
    const Vector pixel_x = all(static_cast<float>(packet.pixel_x)) + whole_x;
    const Vector pixel_y = all(static_cast<float>(packet.pixel_y)) + whole_y;
    const Vector center_x = all(0.5f) - (from_pixel_x - whole_x),
                 center_y = all(0.5f) - (from_pixel_y - whole_y);

    const Vector px = all(object.focal_px) * inverse;
    const Vector qux = (a.x - tangent_x * a.z) * px, quy = (a.y - tangent_y * a.z) * px;
    const Vector qvx = (b.x - tangent_x * b.z) * px, qvy = (b.y - tangent_y * b.z) * px;
    const Vector az = a.z * inverse, bz = b.z * inverse;
    const Vector r2 = all(filter_squared);
    const Vector uu = qux * qux + quy * quy, vv = qvx * qvx + qvy * qvy, uv = qux * qvx + quy * qvy;
    const Vector gxx = (qux * qux + qvx * qvx) + r2, gyy = (quy * quy + qvy * qvy) + r2;
    const Vector gxy = qux * quy + qvx * qvy;
    const Vector det = qux * qvy - quy * qvx;
    const Vector det_g = det * det + r2 * ((uu + vv) + r2);
    const Vector inverse_det_g = all(1.0f) / det_g;
    const Vector hx = qux * az + qvx * bz, hy = quy * az + qvy * bz;
    const Vector gx = (det * (qvy * az - quy * bz) + r2 * hx) * inverse_det_g;
    const Vector gy = (det * (qux * bz - qvx * az) + r2 * hy) * inverse_det_g;
    const Vector ux = root(gyy * inverse_det_g), uy = all(0.0f) - ux * (gxy / gyy);
    const Vector vy = all(1.0f) / root(gyy);
    const Vector peak = object.filter_px > 0.0f ? magnitude(det) * root(inverse_det_g) : all(1.0f);

    // Depth tolerance: principal axes by half angles.
    const Vector difference = uu - vv, twice = uv + uv;
    const Vector h = root(difference * difference + twice * twice);
    const Vector ratio = choose(h == all(0.0f), all(1.0f), difference / h);
    const Vector cosine_large = root(all(0.5f) + all(0.5f) * magnitude(ratio));
    const Vector sine_small = choose(h == all(0.0f), all(0.0f), (twice / h) * (all(0.5f) / cosine_large));
    const Mask leans = ratio < all(0.0f);
    // Where the angle is beyond 45° sine and cosine change places, and the sine keeps its sign.
    const Vector sign = choose(sine_small < all(0.0f), all(-1.0f), all(1.0f));
    const Vector cosine = choose(leans, magnitude(sine_small), cosine_large);
    const Vector sine = choose(leans, sign * cosine_large, sine_small);
    const Vector major_squared = all(0.5f) * ((uu + vv) + h);
    const Vector major = root(major_squared);
    const Vector minor = choose(major == all(0.0f), all(0.0f), magnitude(det) / major);
    const Vector depth_major = cosine * az + sine * bz, depth_minor = cosine * bz - sine * az;
    const Vector quarter = all(0.25f * object.filter_px);
    // A filter of radius 0 keeps the disc, whose own size it is then.
    const Vector least = all(1.17549435e-38f);
    const Vector major_filtered = root(major_squared + r2), minor_filtered = root(minor * minor + r2);
    const Vector major_slope = (major_filtered / larger(larger(major, quarter), least)) * depth_major;
    const Vector minor_slope = (minor_filtered / larger(larger(minor, quarter), least)) * depth_minor;
    const Vector per_px = all(1.0f / object.focal_px);
    const Vector major_across = major_filtered * per_px, minor_across = minor_filtered * per_px;
    const Vector flat = (major_across * major_across + minor_across * minor_across) +
                        (major_slope * major_slope + minor_slope * minor_slope);
    const Vector own = ((a.x * a.x + a.y * a.y) + a.z * a.z) + ((b.x * b.x + b.y * b.y) + b.z * b.z);
    const Vector size = object.filter_px > 0.0f ? depth * root(all(0.5f) * flat) : root(all(0.5f) * own);
    const Vector tolerance = all(object.depth_tolerance) * size;

    // Extent of the projected disc: x = w_x / (1 + g·w) at its largest and least.
    const Vector reach_squared = larger(gx * hx + gy * hy, all(0.0f));
    const Vector reach = root(reach_squared);
    const Vector rest = all(1.0f) - reach_squared;
    const Vector root_x = root(hx * hx + rest * gxx), root_y = root(hy * hy + rest * gyy);
    const Vector padding = all(0.0078125f) + all(1e-5f) * ((root_x + root_y) / rest);
    const Vector low_x = ((all(0.0f) - hx) - root_x) / rest - padding,
                 high_x = (root_x - hx) / rest + padding;
    const Vector low_y = ((all(0.0f) - hy) - root_y) / rest - padding,
                 high_y = (root_y - hy) / rest + padding;
    const Vector x_begin = pixel_x + (all(0.0f) - floor_of(center_x - low_x));
    const Vector x_end = pixel_x + (floor_of(high_x - center_x) + all(1.0f));
    const Vector y_begin = pixel_y + (all(0.0f) - floor_of(center_y - low_y));
    const Vector y_end = pixel_y + (floor_of(high_y - center_y) + all(1.0f));
    const Vector nearest = depth * (all(1.0f) - reach);

    // Written so that what is not a number is not simple. What lies much nearer to the eye than its packet's
    // origin has lost its digits in the sum.
    constexpr float most_px = 65536.0f, most_from_origin_px = 2048.0f, most_from_origin_depths = 4.0f;
    const Mask exact = magnitude(from_origin.z) <= all(most_from_origin_depths) * depth;
    Mask simple = exact & (all(object.near) < nearest);
    simple = simple & (reach_squared <= all(0.98f));
    simple = simple & (magnitude(tangent_x) <= all(object.max_tangent_x));
    simple = simple & (magnitude(tangent_y) <= all(object.max_tangent_y));
    simple =
        simple & (magnitude(pixel_x) <= all(16.0f * most_px)) & (magnitude(pixel_y) <= all(16.0f * most_px));
    simple = simple & ((root_x + root_y) <= all(most_px));
    simple = simple & (magnitude(from_pixel_x) <= all(most_from_origin_px)) &
             (magnitude(from_pixel_y) <= all(most_from_origin_px));
    simple = simple & (tolerance <= all(1e30f)) & (all(1e-30f) <= depth) & (depth <= all(1e30f));
    simple = simple & (all(1e-30f) <= det_g) & (ux <= all(1e15f)) & (vy <= all(1e15f)) &
             (peak <= all(1.0f + 1e-5f));
    Mask shown = simple & (all(1e-30f) <= peak);

    // A centre beyond the guard band, but a disc that certainly stays off the film.
    const Vector wide = (((magnitude(a.x) + magnitude(a.y)) + magnitude(a.z)) +
                         ((magnitude(b.x) + magnitude(b.y)) + magnitude(b.z))) *
                            inverse +
                        all(object.filter_px / object.focal_px);
    const Vector most = (all(2.0f * object.focal_px) * wide) *
                        ((all(1.0f) + magnitude(tangent_x)) + magnitude(tangent_y)) / (all(1.0f) - wide);
    Mask bounded = (wide < all(0.5f)) & (all(object.near) < depth * (all(1.0f) - wide));
    Mask off =
        (pixel_x + most < all(-2.0f)) | (all(static_cast<float>(object.film_width) + 2.0f) < pixel_x - most);
    off = off | (pixel_y + most < all(-2.0f)) |
          (all(static_cast<float>(object.film_height) + 2.0f) < pixel_y - most);
    // Wholly nearer than the near plane.
    const Mask behind = depth * all(1.0f) + depth * magnitude(wide) < all(object.near);
    const Mask gone = exact & ((bounded & off) | (behind & (all(0.0f) < depth)));

    Mask mixed = all(1.0f) < all(0.0f);
    if (object.one_sided) {
      const Vector side = all(object.mirrored);
      const Vector nx = side * (a.y * b.z - a.z * b.y), ny = side * (a.z * b.x - a.x * b.z);
      const Vector nz = side * (a.x * b.y - a.y * b.x);
      const Vector towards = (nx * tangent_x + ny * tangent_y) + nz;
      const Vector reach_x = larger(magnitude(low_x), magnitude(high_x));
      const Vector reach_y = larger(magnitude(low_y), magnitude(high_y));
      const Vector scale = (magnitude(nx) + magnitude(ny)) + magnitude(nz);
      const Vector varies = (magnitude(nx) * reach_x + magnitude(ny) * reach_y) * per_px + all(1e-5f) * scale;
      shown = shown & (towards - varies < all(0.0f));
      mixed = without(shown, towards + varies < all(0.0f));
      shown = without(shown, mixed);
    }

    const Mask within = (x_begin < right) & (left < x_end) & (y_begin < bottom) & (top < y_end);
    seen |= bits(without(shown, gone) & within) << lane;
    general |= (bits(without(mixed, gone)) | (~bits(simple) & ~bits(gone) & ((1u << vector_lanes) - 1u)))
               << lane;
    store(pixel_x, placed.pixel_x + lane);
    store(pixel_y, placed.pixel_y + lane);
    store(center_x, placed.center_x + lane);
    store(center_y, placed.center_y + lane);
    store(ux, placed.ux + lane);
    store(uy, placed.uy + lane);
    store(vy, placed.vy + lane);
    store(gx, placed.gx + lane);
    store(gy, placed.gy + lane);
    store(depth, placed.depth + lane);
    store(nearest - all(1e-5f) * nearest, placed.nearest + lane);
    store(peak, placed.peak + lane);
    store(tolerance, placed.tolerance + lane);
    store(x_begin, placed.x_begin + lane);
    store(x_end, placed.x_end + lane);
    store(y_begin, placed.y_begin + lane);
    store(y_end, placed.y_end + lane);
  }
  placed.seen = seen & points.lanes;
  placed.general = general & points.lanes;
}

constexpr float lanes_x_4x4[16] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
constexpr float lanes_y_4x4[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
constexpr float lanes_x_8x2[16] = {0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7};
constexpr float lanes_y_8x2[16] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};

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
SWEPT_LANE Met meet(const Disc& disc, Vector x, Vector y, Vector near) {
  const Vector dx = x + disc.center_x, dy = y + disc.center_y;
  const Vector w = (all(1.0f) - disc.gx * dx) - disc.gy * dy;
  const Vector inverse = all(1.0f) / w;
  const Vector u = (disc.ux * dx + disc.uy * dy) * inverse, v = (disc.vy * dy) * inverse;
  Met met;
  met.radius_squared = u * u + v * v;
  met.depth = disc.depth * inverse;
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

template <class Block>
SWEPT_LANE void bring_disc_to_front(const PlacedPacket& placed, int lane, const Span& span, int x_film,
                                    int y_film, float near, CellBuffers& cell) {
  const Disc disc(placed, lane);
  const Vector tolerance = all(placed.tolerance[lane]), near_plane = all(near);
  for_each_block<Block>(
      span, static_cast<float>(x_film) - placed.pixel_x[lane],
      static_cast<float>(y_film) - placed.pixel_y[lane], [&](int pixel, Vector x, Vector y, int part) {
        const Met met = meet(disc, x, y, near_plane);
        const Vector front = Block::load_from(cell.front + pixel, part);
        const Vector limit = Block::load_from(cell.limit + pixel, part);
        const Mask nearer = met.inside & (met.depth < front), equal = met.inside & (met.depth == front);
        if (vector_lanes > 1 && bits(nearer | equal) == 0) return;
        const Vector reached = met.depth + tolerance;
        Block::store_to(choose(nearer, met.depth, front), cell.front + pixel, part);
        Block::store_to(choose(nearer, reached, choose(equal, larger(limit, reached), limit)),
                        cell.limit + pixel, part);
      });
}

void bring_to_front_text(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film, int width,
                         int height, const SurfaceRule& rule, CellBuffers& cell) {
  for_each_lane(placed, lanes, x_film, y_film, width, height, [&](int lane, const Span& span) {
    if (!may_be_in_front(cell, span, placed.nearest[lane])) return;
    if (prefers_4x4(span))
      bring_disc_to_front<Block4x4>(placed, lane, span, x_film, y_film, rule.near, cell);
    else
      bring_disc_to_front<Block8x2>(placed, lane, span, x_film, y_film, rule.near, cell);
  });
}

template <class Block>
SWEPT_LANE void add_disc_to_front(const PlacedPacket& placed, int lane, const Span& span, int x_film,
                                  int y_film, const SurfaceRule& rule, CellBuffers& cell) {
  const Disc disc(placed, lane);
  const Vector near_plane = all(rule.near), sharpness = all(-rule.delta), peak = all(placed.peak[lane]);
  const Vector red = all(placed.red[lane]), green = all(placed.green[lane]), blue = all(placed.blue[lane]);
  const Vector alpha = all(placed.alpha[lane]);
  for_each_block<Block>(
      span, static_cast<float>(x_film) - placed.pixel_x[lane],
      static_cast<float>(y_film) - placed.pixel_y[lane], [&](int pixel, Vector x, Vector y, int part) {
        const Met met = meet(disc, x, y, near_plane);
        const Mask counts = met.inside & (met.depth <= Block::load_from(cell.limit + pixel, part));
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

void add_to_front_text(const PlacedPacket& placed, std::uint32_t lanes, int x_film, int y_film, int width,
                       int height, const SurfaceRule& rule, CellBuffers& cell) {
  for_each_lane(placed, lanes, x_film, y_film, width, height, [&](int lane, const Span& span) {
    if (!may_be_in_front(cell, span, placed.nearest[lane])) return;
    if (prefers_4x4(span))
      add_disc_to_front<Block4x4>(placed, lane, span, x_film, y_film, rule, cell);
    else
      add_disc_to_front<Block8x2>(placed, lane, span, x_film, y_film, rule, cell);
  });
}

std::size_t find_behind_text(const PlacedPacket& placed, std::uint32_t lanes, std::uint32_t first_disc,
                             int x_film, int y_film, int width, int height, const SurfaceRule& rule,
                             const CellBuffers& cell, FragmentBehind* out) {
  std::size_t count = 0;
  for_each_lane(placed, lanes, x_film, y_film, width, height, [&](int lane, const Span& span) {
    if (!light_reaches(cell, span)) return;
    const Disc disc(placed, lane);
    const Vector near_plane = all(rule.near), sharpness = all(-rule.delta), peak = all(placed.peak[lane]);
    for_each_block<Block4x4>(
        span, static_cast<float>(x_film) - placed.pixel_x[lane],
        static_cast<float>(y_film) - placed.pixel_y[lane], [&](int pixel, Vector x, Vector y, int part) {
          const Vector limit = Block4x4::load_from(cell.behind + pixel, part);
          if (bits(limit < all(infinity)) == 0) return;
          const Met met = meet(disc, x, y, near_plane);
          const Mask behind = met.inside & (limit < met.depth);
          std::uint32_t found = bits(behind);
          if (found == 0) return;
          alignas(64) float rho[vector_lanes], depth[vector_lanes];
          store(peak * exp_of(sharpness * smaller(met.radius_squared, all(1.0f))), rho);
          store(met.depth, depth);
          for (; found != 0; found &= found - 1) {
            const int i = __builtin_ctz(found), in_block = part * vector_lanes + i;
            out[count++] = {depth[i], rho[i], first_disc + static_cast<std::uint32_t>(lane),
                            static_cast<std::uint32_t>(pixel + (in_block / 4) * cell_pitch + in_block % 4)};
          }
        });
  });
  return count;
}

void clear_text(CellBuffers& cell, int height) {
  const int count = (height + 4) * cell_pitch;
  const Vector none = all(infinity), zero = all(0.0f);
  for (int i = 0; i < count; i += vector_lanes) {
    store(none, cell.front + i);
    store(none, cell.limit + i);
    for (float* sums : {cell.weight, cell.red, cell.green, cell.blue, cell.alpha, cell.depth})
      store(zero, sums + i);
  }
  for (float& limit : cell.patch_limit) limit = infinity;
}

void measure_patches_text(CellBuffers& cell, int height) {
  for (int patch_y = 0; patch_y < cell_patches; ++patch_y) {
    // Rows that the film does not have hold nothing and hide nothing.
    const int y_end = (patch_y + 1) * patch_px < height ? (patch_y + 1) * patch_px : height;
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
      cell.patch_limit[patch_y * cell_patches + patch_x] = most;
    }
  }
}

bool shade_front_text(const SurfaceRule& rule, CellBuffers& cell, int height) {
  const Vector edge = all(rule.edge_weight), one = all(1.0f), least = all(1.17549435e-38f);
  const Vector opaque = all(0x1p-24f);
  std::uint32_t any = 0;
  for (bool& leaks : cell.patch_leaks) leaks = false;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < cell_px; x += vector_lanes) {
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
      if (bits(leaks) == 0) continue;
      any = 1;
      for (int patch = x / patch_px; patch <= (x + vector_lanes - 1) / patch_px; ++patch)
        cell.patch_leaks[y / patch_px * cell_patches + patch] = true;
    }
  return any != 0;
}

void add_instant_text(const CellBuffers& cell, const InstantWeights& weights, const float background[3],
                      CellSums& sums, int height) {
  const Vector w = all(weights.weight), s = all(weights.alternating), one = all(1.0f);
  float* const quarter = weights.odd != 0.0f ? sums.odd : sums.even;
  const Vector q = all(weights.odd != 0.0f ? weights.odd : weights.even);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < cell_px; x += vector_lanes) {
      const int i = y * cell_pitch + x;
      const Vector alpha = load(cell.alpha + i), left = one - alpha;
      const auto add = [&](Vector what, float* sum) { store(load(sum + i) + what, sum + i); };
      const Vector red = load(cell.red + i), green = load(cell.green + i), blue = load(cell.blue + i);
      add(w * red, sums.red);
      add(w * green, sums.green);
      add(w * blue, sums.blue);
      add(w * alpha, sums.alpha);
      add(w * load(cell.depth + i), sums.depth);
      if (weights.alternating == 0.0f) continue;
      const Vector over_red = red + left * all(background[0]), over_green = green + left * all(background[1]);
      const Vector over_blue = blue + left * all(background[2]);
      add(s * over_red, sums.alternating_red);
      add(s * over_green, sums.alternating_green);
      add(s * over_blue, sums.alternating_blue);
      add(q * ((over_red + over_green) + over_blue), quarter);
    }
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
