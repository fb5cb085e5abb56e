// The light of pieces of time, summed up. Source: model section 15; Gauss and Legendre's quadrature.
//
// Within a piece colours, shares of corners and depths are smooth, and what is transparent keeps its order.
// Three nodes are exact to the fifth degree; where colours vary by more than 2⁻¹⁰ within a piece its halves
// are summed as well, and halved on until the sum changes by less than 10⁻⁷ of the light of the piece.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "abuffer/resolve/place_sweep.h"
#include "splat/interval/composite.h"

namespace swept {

/// Premultiplied colour, and depth times alpha.
struct LightSum {
  double v[5] = {0.0, 0.0, 0.0, 0.0, 0.0};

  void add(const LightSum& o, double weight) {
    for (int c = 0; c < 5; ++c) v[c] += weight * o.v[c];
  }
};

/// Of Gauss's three on [0, 1], from the first on.
struct LightNode {
  double at, weight;
};
inline constexpr LightNode light_nodes[3] = {{0.5 - 0.38729833462074168852, 5.0 / 18.0},  // √0.6/2
                                             {0.5, 8.0 / 18.0},
                                             {0.5 + 0.38729833462074168852, 5.0 / 18.0}};

/// Adds ∫ at(time) ds over the shares of light from `first` to `last`. `even`: colours are known not to
/// change. Calls part(a, b) for each stretch of it that was summed up by its own nodes.
template <class At, class Part>
void add_light(double first, double last, bool even, const LightOverTime& light, const At& at, LightSum& sum,
               const Part& part) {
  struct Nodes {
    LightSum mean;
    double spread = 0.0;
  };
  const auto nodes = [&](double a, double b) {
    LightSum looks[3];
    Nodes n;
    for (int k = 0; k < 3; ++k) {
      looks[k] = at(light.time(a + light_nodes[k].at * (b - a)));
      n.mean.add(looks[k], light_nodes[k].weight);
    }
    for (int c = 0; c < 4; ++c)
      n.spread = std::max(
          {n.spread, std::abs(looks[0].v[c] - looks[1].v[c]), std::abs(looks[2].v[c] - looks[1].v[c])});
    return n;
  };
  const auto refine = [&](const auto& self, double a, double b, const Nodes& whole, int halvings) -> void {
    if (even || halvings == 0 || !(whole.spread > 0x1p-10)) {
      sum.add(whole.mean, b - a);
      part(a, b);
      return;
    }
    const double half = 0.5 * a + 0.5 * b;
    const Nodes left = nodes(a, half), right = nodes(half, b);
    double off = 0.0, most = 1.0;
    for (int c = 0; c < 4; ++c) {
      off = std::max(off, std::abs(0.5 * left.mean.v[c] + 0.5 * right.mean.v[c] - whole.mean.v[c]));
      most = std::max(most, std::abs(whole.mean.v[c]));
    }
    if (off <= 1e-7 * most) {
      sum.add(left.mean, half - a);
      sum.add(right.mean, b - half);
      part(a, half);
      part(half, b);
      return;
    }
    self(self, a, half, left, halvings - 1);
    self(self, half, b, right, halvings - 1);
  };
  if (first < last) refine(refine, first, last, nodes(first, last), 10);
}
template <class At>
void add_light(double first, double last, bool even, const LightOverTime& light, const At& at,
               LightSum& sum) {
  add_light(first, last, even, light, at, sum, [](double, double) {});
}

/// What a place sees of a mesh at a time at which it sees these triangles in this order.
inline LightSum light_at(std::span<const std::uint32_t> seen, const std::vector<TriangleStretch>& triangles,
                         const Eigen::Vector3d& ray, double time) {
  LightSum sum;
  double left = 1.0;
  for (const std::uint32_t t : seen) {
    const TriangleStretch::Look look = triangles[t].look(ray, time);
    for (int c = 0; c < 4; ++c) sum.v[c] += left * look.rgba[c];
    sum.v[4] += left * look.rgba[3] * look.depth;
    left *= 1.0 - look.rgba[3];
    if (left < double{opaque_transmittance}) break;
  }
  return sum;
}

}  // namespace swept
