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

/// Adds ∫ at(time) ds over the shares of light from `first` to `last`. `even`: colours are known not to
/// change.
template <class At>
void add_light(double first, double last, bool even, const LightOverTime& light, const At& at,
               LightSum& sum) {
  struct Nodes {
    LightSum mean;
    double spread = 0.0;
  };
  const auto nodes = [&](double a, double b) {
    constexpr double offset = 0.38729833462074168852, side = 5.0 / 18.0, middle = 8.0 / 18.0;  // √0.6/2
    const LightSum looks[3] = {at(light.time(a + (0.5 - offset) * (b - a))),
                               at(light.time(0.5 * a + 0.5 * b)),
                               at(light.time(a + (0.5 + offset) * (b - a)))};
    Nodes n;
    n.mean.add(looks[0], side);
    n.mean.add(looks[1], middle);
    n.mean.add(looks[2], side);
    for (int c = 0; c < 4; ++c)
      n.spread = std::max(
          {n.spread, std::abs(looks[0].v[c] - looks[1].v[c]), std::abs(looks[2].v[c] - looks[1].v[c])});
    return n;
  };
  const auto refine = [&](const auto& self, double a, double b, const Nodes& whole, int halvings) -> void {
    if (even || halvings == 0 || !(whole.spread > 0x1p-10)) {
      sum.add(whole.mean, b - a);
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
      return;
    }
    self(self, a, half, left, halvings - 1);
    self(self, half, b, right, halvings - 1);
  };
  if (first < last) refine(refine, first, last, nodes(first, last), 10);
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
