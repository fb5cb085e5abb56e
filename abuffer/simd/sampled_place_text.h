// Sixteen points placed at an instant: part of sampled_math_text.h.
#pragma once

#include "abuffer/simd/sampled_lanes_text.h"

namespace swept {
namespace {

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
///
/// Of an orthographic camera depths are in world units, no x or y is divided by them, and a ray meets the
/// plane in w = d at depth z + g·d.
template <bool parallel>
SWEPT_LANE void place_lanes(const PacketPoints& points, const ObjectPlace& object, const PacketPlace& packet,
                            int x, int y, int width, int height, PlacedPacket& placed) {
  const Vector left = all(static_cast<float>(x)), right = all(static_cast<float>(x + width));
  const Vector top = all(static_cast<float>(y)), bottom = all(static_cast<float>(y + height));
  std::uint32_t seen = 0, general = 0, back = 0;
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
    const Vector inverse = parallel ? all(1.0f) : all(1.0f) / depth;
    const Vector across_x =
        parallel ? from_origin.x : (from_origin.x - all(packet.tangent_x) * from_origin.z) * inverse;
    const Vector across_y =
        parallel ? from_origin.y : (from_origin.y - all(packet.tangent_y) * from_origin.z) * inverse;
    const Vector tangent_x = parallel ? all(0.0f) : all(packet.tangent_x) + across_x,
                 tangent_y = parallel ? all(0.0f) : all(packet.tangent_y) + across_y;
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
    const Vector unit = parallel ? all(1.0f) : depth;
    const Vector size = object.filter_px > 0.0f ? unit * root(all(0.5f) * flat) : root(all(0.5f) * own);
    const Vector tolerance = all(object.depth_tolerance) * size;

    // Extent of the projected disc: x = w_x / (1 + g·w) at its largest and least.
    const Vector depth_reach_squared = larger(gx * hx + gy * hy, all(0.0f));
    const Vector reach = root(depth_reach_squared);
    const Vector reach_squared = parallel ? all(0.0f) : depth_reach_squared;
    const Vector rest = all(1.0f) - reach_squared;
    const Vector mid_x = parallel ? all(0.0f) : hx, mid_y = parallel ? all(0.0f) : hy;
    const Vector root_x = root(mid_x * mid_x + rest * gxx), root_y = root(mid_y * mid_y + rest * gyy);
    const Vector padding = all(0.0078125f) + all(1e-5f) * ((root_x + root_y) / rest);
    const Vector low_x = ((all(0.0f) - mid_x) - root_x) / rest - padding,
                 high_x = (root_x - mid_x) / rest + padding;
    const Vector low_y = ((all(0.0f) - mid_y) - root_y) / rest - padding,
                 high_y = (root_y - mid_y) / rest + padding;
    const Vector x_begin = pixel_x + (all(0.0f) - floor_of(center_x - low_x));
    const Vector x_end = pixel_x + (floor_of(high_x - center_x) + all(1.0f));
    const Vector y_begin = pixel_y + (all(0.0f) - floor_of(center_y - low_y));
    const Vector y_end = pixel_y + (floor_of(high_y - center_y) + all(1.0f));
    const Vector nearest = parallel ? depth - reach : depth * (all(1.0f) - reach);

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
    const Vector spread = all(2.0f * object.focal_px) * wide;
    const Vector most =
        parallel ? spread
                 : spread * ((all(1.0f) + magnitude(tangent_x)) + magnitude(tangent_y)) / (all(1.0f) - wide);
    Mask bounded =
        parallel ? wide <= wide : (wide < all(0.5f)) & (all(object.near) < depth * (all(1.0f) - wide));
    Mask off =
        (pixel_x + most < all(-2.0f)) | (all(static_cast<float>(object.film_width) + 2.0f) < pixel_x - most);
    off = off | (pixel_y + most < all(-2.0f)) |
          (all(static_cast<float>(object.film_height) + 2.0f) < pixel_y - most);
    // Wholly nearer than the near plane.
    const Mask behind =
        parallel ? depth + wide < all(object.near)
                 : (depth * all(1.0f) + depth * magnitude(wide) < all(object.near)) & (all(0.0f) < depth);
    const Mask gone = parallel ? (bounded & off) | behind : exact & ((bounded & off) | behind);

    std::uint32_t mixed = 0;
    if (object.one_sided || points.oriented != 0) {
      const Vector side = all(object.mirrored);
      const Vector nx = side * (a.y * b.z - a.z * b.y), ny = side * (a.z * b.x - a.x * b.z);
      const Vector nz = side * (a.x * b.y - a.y * b.x);
      const Vector towards = (nx * tangent_x + ny * tangent_y) + nz;
      const Vector reach_x = larger(magnitude(low_x), magnitude(high_x));
      const Vector reach_y = larger(magnitude(low_y), magnitude(high_y));
      const Vector scale = (magnitude(nx) + magnitude(ny)) + magnitude(nz);
      const Vector turns =
          parallel ? all(0.0f) : (magnitude(nx) * reach_x + magnitude(ny) * reach_y) * per_px;
      const Vector varies = turns + all(1e-5f) * scale;
      const Mask not_away = towards - varies < all(0.0f);
      if (object.one_sided) shown = shown & not_away;
      back |= bits(without(shown, not_away)) << lane;
      // Of one and the same disc some pixels would see the front, and others the back.
      mixed = bits(without(without(shown & not_away, towards + varies < all(0.0f)), gone));
      if (!object.one_sided) mixed &= points.oriented >> lane;
    }

    const Mask within = (x_begin < right) & (left < x_end) & (y_begin < bottom) & (top < y_end);
    seen |= (bits(without(shown, gone) & within) & ~mixed) << lane;
    general |= ((mixed & bits(within)) | (~bits(simple) & ~bits(gone) & ((1u << vector_lanes) - 1u))) << lane;
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
    store(nearest - all(1e-5f) * (parallel ? magnitude(depth) : nearest), placed.nearest + lane);
    store(peak, placed.peak + lane);
    store(tolerance, placed.tolerance + lane);
    store(x_begin, placed.x_begin + lane);
    store(x_end, placed.x_end + lane);
    store(y_begin, placed.y_begin + lane);
    store(y_end, placed.y_end + lane);
  }
  placed.seen = seen & points.lanes;
  placed.general = general & points.lanes;
  placed.back = back & points.oriented;
  placed.front = ~back & points.oriented;
}

inline void place_text(const PacketPoints& points, const ObjectPlace& object, const PacketPlace& packet,
                       int x, int y, int width, int height, PlacedPacket& placed) {
  if (object.orthographic)
    place_lanes<true>(points, object, packet, x, y, width, height, placed);
  else
    place_lanes<false>(points, object, packet, x, y, width, height, placed);
}

}  // namespace
}  // namespace swept
