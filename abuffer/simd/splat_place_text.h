// Sixteen splats placed at an instant. Included by splat_math_text.h alone.
//
// Sources: Kerbl et al. 2023, section 4 (Σ' = J W Σ Wᵀ Jᵀ, harmonics); Huang et al. 2024, section 4 (discs).
#pragma once

#include "abuffer/simd/sampled_lanes_text.h"
#include "abuffer/simd/splat_math.h"

namespace swept {
namespace {

/// ½ log₂ e: exp(−½ r²) = 2^−(half_log2_e · r²).
inline constexpr float half_log2_e = 0.72134752f;

struct Lanes3 {
  Vector x, y, z;
};

SWEPT_LANE Lanes3 turned(const float* m, Lanes3 a) {
  return {(all(m[0]) * a.x + all(m[1]) * a.y) + all(m[2]) * a.z,
          (all(m[3]) * a.x + all(m[4]) * a.y) + all(m[5]) * a.z,
          (all(m[6]) * a.x + all(m[7]) * a.y) + all(m[8]) * a.z};
}
SWEPT_LANE Lanes3 load_3(const float* from) {
  return {load(from), load(from + packet_size), load(from + 2 * packet_size)};
}
SWEPT_LANE Vector held(Vector a, float low, float high) { return smaller(larger(a, all(low)), all(high)); }

/// All lanes of a packet, by field.
struct PlacedFields {
  alignas(64) float pixel_x[packet_size], pixel_y[packet_size], center_x[packet_size], center_y[packet_size];
  alignas(64) float ux[packet_size], uy[packet_size], vy[packet_size], opacity[packet_size];
  alignas(64) float red[packet_size], green[packet_size], blue[packet_size], depth[packet_size];
  alignas(64) float gx[packet_size], gy[packet_size];
  alignas(64) float x_first[packet_size], x_last[packet_size], y_first[packet_size], y_last[packet_size];
};

/// What a splat looks like on the film, of both kinds.
struct Shape {
  Vector ux, uy, vy, gx, gy;
  Vector left, right, up, down;  ///< how far it reaches from its centre, px, ≥ 0
  Vector opacity;
  Mask seen;
};

/// Real harmonics of a unit direction: ½ + Σ coefficient · basis, not below 0.
SWEPT_LANE void shade(const SplatFields& splats, Lanes3 d, int part, Vector (&color)[3]) {
  const Vector x = d.x, y = d.y, z = d.z;
  Vector basis[16];
  basis[0] = all(0.28209479f);
  int count = 1;
  if (splats.coefficients > 1) {
    const Vector c = all(0.48860251f);
    basis[1] = all(-0.48860251f) * y;
    basis[2] = c * z;
    basis[3] = all(-0.48860251f) * x;
    count = 4;
  }
  const Vector xx = x * x, yy = y * y, zz = z * z, xy = x * y;
  if (splats.coefficients > 4) {
    basis[4] = all(1.0925484f) * xy;
    basis[5] = all(-1.0925484f) * (y * z);
    basis[6] = all(0.31539157f) * ((zz + zz) - (xx + yy));
    basis[7] = all(-1.0925484f) * (x * z);
    basis[8] = all(0.54627422f) * (xx - yy);
    count = 9;
  }
  if (splats.coefficients > 9) {
    const Vector four = all(4.0f) * zz - (xx + yy), three = all(3.0f);
    basis[9] = all(-0.59004359f) * (y * (three * xx - yy));
    basis[10] = all(2.8906114f) * (xy * z);
    basis[11] = all(-0.45704580f) * (y * four);
    basis[12] = all(0.37317633f) * (z * ((zz + zz) - three * (xx + yy)));
    basis[13] = all(-0.45704580f) * (x * four);
    basis[14] = all(1.4453057f) * (z * (xx - yy));
    basis[15] = all(-0.59004359f) * (x * (xx - three * yy));
    count = 16;
  }
  const float* from = splats.harmonics + part * vector_lanes;
  for (Vector& c : color) c = all(0.5f);
  for (int k = 0; k < count; ++k)
    for (int c = 0; c < 3; ++c, from += packet_size) color[c] = color[c] + basis[k] * load(from);
  for (Vector& c : color) c = larger(c, all(0.0f));
}

/// √(2 ln(opacity / least alpha)), or a little more: ln x ≤ 8 (y − 1)/√y with y the eighth root of x ≥ 1.
SWEPT_LANE Vector reach_of(Vector over) {
  const Vector y = root(root(root(over)));
  return root(all(16.0f) * ((y - all(1.0f)) / root(y)));
}

SWEPT_LANE Shape shape_of(const SplatView& view, Lanes3 at, const Lanes3 (&axes)[3], Vector opacity) {
  // Parallel rays: x/z and y/z are held to 0.
  const Vector inverse = view.orthographic ? all(1.0f) : all(1.0f) / at.z;
  const Vector x = held(at.x * inverse, view.low_x, view.high_x),
               y = held(at.y * inverse, view.low_y, view.high_y);
  const Vector scale_x = all(view.focal_x) * inverse, scale_y = all(view.focal_y) * inverse;
  // Each axis on the film. What is longer than this is as good as endless.
  constexpr float longest = 1e8f;
  Vector px[3], py[3];
  for (int i = 0; i < 3; ++i) {
    px[i] = held(scale_x * (axes[i].x - x * axes[i].z), -longest, longest);
    py[i] = held(scale_y * (axes[i].y - y * axes[i].z), -longest, longest);
  }
  // The determinant as a sum of squares: thin splats leave nothing of a difference.
  const auto cross = [&](int i, int j) {
    const Vector c = px[i] * py[j] - px[j] * py[i];
    return c * c;
  };
  const Vector before = (cross(0, 1) + cross(0, 2)) + cross(1, 2);
  const Vector xx = (px[0] * px[0] + px[1] * px[1]) + px[2] * px[2];
  const Vector yy = (py[0] * py[0] + py[1] * py[1]) + py[2] * py[2];
  const Vector xy = (px[0] * py[0] + px[1] * py[1]) + px[2] * py[2];
  const Vector dilation = all(view.dilation_px2);
  const Vector a = xx + dilation, c = yy + dilation;
  const Vector determinant = (before + dilation * (xx + yy)) + dilation * dilation;
  Shape shape;
  shape.opacity = view.antialiased ? opacity * root(before / determinant) : opacity;
  // (C dx² − 2 B dx dy + A dy²) / det = (dx − B/C dy)² C/det + dy²/C.
  shape.ux = root(all(half_log2_e) * (c / determinant));
  shape.uy = all(0.0f) - (xy / c) * shape.ux;
  shape.vy = root(all(half_log2_e) / c);
  const Vector over = shape.opacity / all(view.least_alpha);
  shape.seen = (all(1.0f) <= over) & (all(0.0f) < determinant);
  const Vector reach = reach_of(larger(over, all(1.0f)));
  shape.gx = all(half_log2_e) * (reach * reach);
  shape.gy = all(0.0f);
  shape.left = shape.right = reach * root(a);
  shape.up = shape.down = reach * root(c);
  return shape;
}

/// A disc's reach along one coordinate of the film: the roots of a quadratic that its rim touches. `a` and
/// `b` are the axes' homogeneous coordinates from the centre, `wa`, `wb` and `wc` their depths and the
/// centre's.
SWEPT_LANE void disc_reach(Vector a, Vector b, Vector wa, Vector wb, Vector wc, Vector reach, Vector low_pass,
                           Vector& below, Vector& above) {
  const Vector square = reach * reach;
  const Vector ww = wc * wc - square * (wa * wa + wb * wb);
  const Vector xw = square * (a * wa + b * wb), xx = square * (a * a + b * b);
  const Vector spread = root(larger(xw * xw + ww * xx, all(0.0f)));
  // A rim that reaches the plane through the eye may be anywhere.
  const Mask in_front = all(1e-3f) * (wc * wc) < ww;
  const Vector far = all(1e9f);
  above = larger(choose(in_front, (spread - xw) / ww, far), low_pass);
  below = larger(choose(in_front, (spread + xw) / ww, far), low_pass);
}

SWEPT_LANE Shape disc_shape(const SplatView& view, Lanes3 at, const Lanes3 (&axes)[3], Vector opacity) {
  const Lanes3 &a = axes[0], &b = axes[1];
  const auto cross = [](const Lanes3& p, const Lanes3& q) {
    return Lanes3{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  };
  const auto dot = [](const Lanes3& p, const Lanes3& q) { return (p.x * q.x + p.y * q.y) + p.z * q.z; };
  // Parallel rays see of it what those from an eye do of its shadow at depth 1, whatever its depths.
  const bool parallel = view.orthographic;
  const Vector inverse = all(1.0f) / at.z, zero = all(0.0f);
  const Vector to_x = all(1.0f) / all(view.focal_x), to_y = all(1.0f) / all(view.focal_y);
  const Lanes3 ray{parallel ? zero : at.x * inverse, parallel ? zero : at.y * inverse, all(1.0f)};
  const Lanes3 n = cross(a, b), bn = cross(b, n), na = cross(n, a);
  const Vector square = dot(n, n), along = dot(n, ray);
  const Vector per_square = (parallel ? all(1.0f) : at.z) / square;
  Shape shape;
  shape.gx = (all(0.0f) - n.x * to_x) / along;
  shape.gy = (all(0.0f) - n.y * to_y) / along;
  // (u, v)·W of a pixel (dx, dy) away, and then turned so that v does not depend on dx.
  const Vector u = dot(bn, ray), v = dot(na, ray);
  const Vector m00 = per_square * (shape.gx * u + bn.x * to_x),
               m01 = per_square * (shape.gy * u + bn.y * to_y);
  const Vector m10 = per_square * (shape.gx * v + na.x * to_x),
               m11 = per_square * (shape.gy * v + na.y * to_y);
  const Vector length = root(m00 * m00 + m10 * m10), unit = root(all(half_log2_e));
  shape.ux = unit * length;
  shape.uy = unit * ((m00 * m01 + m10 * m11) / length);
  shape.vy = unit * (magnitude(m00 * m11 - m01 * m10) / length);
  // Where a disc is edge-on, or no disc, the low-pass is left.
  const Vector most = all(1e15f);
  const auto counts = [&](Vector w) { return magnitude(w) < most; };
  const Mask met = counts(shape.gx) & counts(shape.gy) & counts(shape.ux) & counts(shape.uy) &
                   counts(shape.vy) & (all(0.0f) < length);
  shape.gx = parallel ? zero : only(met, shape.gx);
  shape.gy = parallel ? zero : only(met, shape.gy);
  shape.ux = choose(met, shape.ux, most);
  shape.uy = only(met, shape.uy);
  shape.vy = choose(met, shape.vy, most);
  shape.opacity = opacity;
  const Vector over = opacity / all(view.least_alpha);
  shape.seen = all(1.0f) <= over;
  const Vector reach = reach_of(larger(over, all(1.0f))), low_pass = reach * all(0.70710678f);
  const Vector fx = all(view.focal_x), fy = all(view.focal_y);
  const Vector wa = parallel ? zero : a.z, wb = parallel ? zero : b.z, wc = parallel ? all(1.0f) : at.z;
  disc_reach(fx * (a.x - ray.x * a.z), fx * (b.x - ray.x * b.z), wa, wb, wc, reach, low_pass, shape.left,
             shape.right);
  disc_reach(fy * (a.y - ray.y * a.z), fy * (b.y - ray.y * b.z), wa, wb, wc, reach, low_pass, shape.up,
             shape.down);
  return shape;
}

/// Whole pixels, and how far into them, of places counted from the origin's pixel.
SWEPT_LANE void find_pixel(Vector from_origin, int origin, float* pixel, float* center, Vector& whole,
                           Vector& rest) {
  // Farther away nothing is told apart.
  constexpr float farthest = 4e6f;
  const Vector place = held(from_origin, -farthest, farthest), begin = floor_of(place);
  whole = all(static_cast<float>(origin)) + begin;
  rest = place - begin;
  store(whole, pixel);
  store(all(0.5f) - rest, center);
}

/// First and last pixel of a row of `size` whose centres lie within reach; first > last: none does.
SWEPT_LANE Mask find_range(Vector whole, Vector rest, Vector below, Vector above, int size, float* first,
                           float* last) {
  // A little more than the rounding of what follows.
  const Vector slack = all(1e-3f), half = all(0.5f), far = all(2e6f);
  const Vector low = smaller(below * all(1.0001f) + slack, far),
               high = smaller(above * all(1.0001f) + slack, far);
  const Vector begin = larger(whole + (all(0.0f) - floor_of((low - rest) + half)), all(0.0f));
  const Vector end = smaller(whole + floor_of((rest + high) - half), all(static_cast<float>(size - 1)));
  store(begin, first);
  store(end, last);
  return begin <= end;
}

inline std::uint32_t place_text(const SplatFields& splats, const SplatView& view, const SplatOrigin& origin,
                                PlacedSplat* placed) {
  PlacedFields f;
  std::uint32_t seen = 0;
  for (int part = 0; part < vector_parts; ++part) {
    const int i = part * vector_lanes;
    Lanes3 offset = load_3(splats.offset + i);
    if (splats.velocity != nullptr) {
      const Lanes3 velocity = load_3(splats.velocity + i);
      const Vector frames = all(view.frames);
      offset = {offset.x + frames * velocity.x, offset.y + frames * velocity.y,
                offset.z + frames * velocity.z};
    }
    const Lanes3 moved = turned(view.linear, offset);
    const Lanes3 at{all(origin.x) + moved.x, all(origin.y) + moved.y, all(origin.z) + moved.z};
    const Mask in_front = all(view.near) < at.z;
    if (vector_lanes > 1 && bits(in_front) == 0) continue;
    Lanes3 axes[3];
    for (int k = 0; k < 3; ++k) axes[k] = turned(view.linear, load_3(splats.axes + 3 * k * packet_size + i));
    const Vector opacity = load(splats.opacity + i);
    const Shape shape = view.flat ? disc_shape(view, at, axes, opacity) : shape_of(view, at, axes, opacity);

    const Vector scale = view.orthographic ? all(1.0f) : all(1.0f) / at.z;
    Vector whole_x, rest_x, whole_y, rest_y;
    find_pixel(
        all(origin.fraction_x) +
            (all(view.focal_x) * (all(origin.rest_x) + (moved.x - all(origin.tangent_x) * moved.z))) * scale,
        origin.pixel_x, f.pixel_x + i, f.center_x + i, whole_x, rest_x);
    find_pixel(
        all(origin.fraction_y) +
            (all(view.focal_y) * (all(origin.rest_y) + (moved.y - all(origin.tangent_y) * moved.z))) * scale,
        origin.pixel_y, f.pixel_y + i, f.center_y + i, whole_y, rest_y);
    const Mask on_film =
        find_range(whole_x, rest_x, shape.left, shape.right, view.film_width, f.x_first + i, f.x_last + i) &
        find_range(whole_y, rest_y, shape.up, shape.down, view.film_height, f.y_first + i, f.y_last + i);
    const std::uint32_t visible = bits(in_front & shape.seen & on_film);
    if (visible == 0) continue;
    seen |= visible << i;
    store(shape.ux, f.ux + i);
    store(shape.uy, f.uy + i);
    store(shape.vy, f.vy + i);
    store(shape.gx, f.gx + i);
    store(shape.gy, f.gy + i);
    store(shape.opacity, f.opacity + i);
    store(at.z, f.depth + i);
    const Lanes3 ray = view.orthographic ? Lanes3{all(0.0f), all(0.0f), all(1.0f)}
                                         : Lanes3{at.x * scale, at.y * scale, all(1.0f)};
    const Lanes3 looked = turned(view.turn, ray);
    const Vector unit = all(1.0f) / root((looked.x * looked.x + looked.y * looked.y) + looked.z * looked.z);
    Vector color[3];
    shade(splats, {looked.x * unit, looked.y * unit, looked.z * unit}, part, color);
    store(color[0], f.red + i);
    store(color[1], f.green + i);
    store(color[2], f.blue + i);
  }
  seen &= splats.lanes;
  for (std::uint32_t rest = seen; rest != 0; rest &= rest - 1) {
    const int i = __builtin_ctz(rest);
    const auto pixel = [](float v) { return static_cast<std::uint16_t>(v); };
    *placed++ = {f.pixel_x[i],
                 f.pixel_y[i],
                 f.center_x[i],
                 f.center_y[i],
                 f.ux[i],
                 f.uy[i],
                 f.vy[i],
                 f.opacity[i],
                 f.red[i],
                 f.green[i],
                 f.blue[i],
                 f.depth[i],
                 f.gx[i],
                 f.gy[i],
                 pixel(f.x_first[i]),
                 pixel(f.x_last[i]),
                 pixel(f.y_first[i]),
                 pixel(f.y_last[i])};
  }
  return seen;
}

}  // namespace
}  // namespace swept
