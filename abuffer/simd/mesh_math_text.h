// What mesh_math.h declares, in terms of the Vector and Mask that were included before. One text for every
// instruction set.
#pragma once

#include "abuffer/simd/mesh_math.h"

namespace swept {
namespace {

inline constexpr int mesh_parts = pixel_places / vector_lanes;

/// A linear function at the places of a pixel, `part` by `part`.
struct AtPlaces {
  Vector middle, a, b;

  AtPlaces(const Linear& f, double x, double y)
      : middle(all(static_cast<float>(f.at(x, y)))),
        a(all(static_cast<float>(f.a))),
        b(all(static_cast<float>(f.b))) {}
  Vector operator()(int part) const {
    const Vector dx = load(places_in_pixel.x + part * vector_lanes),
                 dy = load(places_in_pixel.y + part * vector_lanes);
    return middle + (a * dx + b * dy);
  }
};

std::uint32_t inside_text(const PlacedTriangle& triangle, double x, double y) {
  const AtPlaces edge[3] = {{triangle.edge[0], x, y}, {triangle.edge[1], x, y}, {triangle.edge[2], x, y}};
  const AtPlaces inverse_depth(triangle.inverse_depth, x, y);
  const Vector zero = all(0.0f);
  std::uint32_t mask = 0;
  for (int part = 0; part < mesh_parts; ++part) {
    Mask in = zero <= zero;
    for (int i = 0; i < 3; ++i) {
      const Vector v = edge[i](part);
      in = in & (triangle.owns[i] ? zero <= v : zero < v);
    }
    if (triangle.cut) {
      const Vector w = inverse_depth(part);
      in = in & (zero < w) & (w <= all(triangle.most_inverse));
    }
    mask |= bits(in) << (part * vector_lanes);
  }
  return mask;
}

bool meet_next_text(const PlacedTriangle* triangles, const MeshFragment* fragments, std::size_t count,
                    double x, double y, const MeshLayer& last, MeshLayer& next) {
  const Vector zero = all(0.0f);
  std::uint32_t any = 0;
  for (int part = 0; part < mesh_parts; ++part) {
    store(zero, next.inverse_depth + part * vector_lanes);
    store(all(-1.0f), next.triangle + part * vector_lanes);
  }
  for (std::size_t f = 0; f < count; ++f) {
    const MeshFragment& fragment = fragments[f];
    const AtPlaces inverse_depth(triangles[fragment.triangle].inverse_depth, x, y);
    const Vector triangle = all(static_cast<float>(fragment.triangle));
    alignas(64) float met[pixel_places];
    for (int k = 0; k < pixel_places; ++k) met[k] = static_cast<float>(fragment.mask >> k & 1);
    for (int part = 0; part < mesh_parts; ++part) {
      const int at = part * vector_lanes;
      const Vector w = inverse_depth(part), w_last = load(last.inverse_depth + at),
                   w_next = load(next.inverse_depth + at);
      const Mask left = (w < w_last) | ((w == w_last) & (load(last.triangle + at) < triangle));
      const Mask better = left & (w_next < w) & (zero < load(met + at));
      store(choose(better, w, w_next), next.inverse_depth + at);
      store(choose(better, triangle, load(next.triangle + at)), next.triangle + at);
      any |= bits(better);
    }
  }
  return any != 0;
}

void color_text(const PlacedTriangle* triangles, std::uint32_t t, double x, double y, const MeshLayer& layer,
                MeshColors& colors) {
  const PlacedTriangle& triangle = triangles[t];
  const AtPlaces edge[3] = {{triangle.edge[0], x, y}, {triangle.edge[1], x, y}, {triangle.edge[2], x, y}};
  const Vector zero = all(0.0f);
  for (int part = 0; part < mesh_parts; ++part) {
    const int at = part * vector_lanes;
    const Mask here = load(layer.triangle + at) == all(static_cast<float>(t));
    if (bits(here) == 0) continue;
    Vector share[3], sum = zero;
    // What rounding puts outside lies on the edge.
    for (int i = 0; i < 3; ++i) {
      share[i] = larger(edge[i](part), zero) * all(triangle.weight[i]);
      sum = sum + share[i];
    }
    const Mask known = zero < sum;
    const Vector divisor = choose(known, sum, all(1.0f));
    const auto mix = [&](float a, float b, float c) {
      const Vector value = (share[0] * all(a) + share[1] * all(b)) + share[2] * all(c);
      return choose(known, value / divisor, all(a));
    };
    const auto put = [&](Vector value, float* to) { store(choose(here, value, load(to + at)), to + at); };
    for (int c = 0; c < 4; ++c)
      put(triangle.plain ? all(triangle.rgba[0][c])
                         : mix(triangle.rgba[0][c], triangle.rgba[1][c], triangle.rgba[2][c]),
          colors.rgba[c]);
    if (triangle.textured)
      for (int c = 0; c < 2; ++c)
        put(mix(triangle.uv[0][c], triangle.uv[1][c], triangle.uv[2][c]), colors.uv[c]);
  }
}

}  // namespace
}  // namespace swept

#define SWEPT_DEFINE_MESH_MATH(variable, text_name)                               \
  namespace swept {                                                               \
  extern const MeshMath variable;                                                 \
  const MeshMath variable = {text_name, inside_text, meet_next_text, color_text}; \
  }
