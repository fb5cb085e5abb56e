// The light of pieces of time, summed up. Source: model section 15; Gauss and Legendre's quadrature.
//
// Within a piece colours, shares of corners and depths are smooth, and what is transparent keeps its order.
// Three nodes are exact to the fifth degree; where colours, or depths, vary by more than 2⁻¹⁰ within a piece
// its halves are summed as well, and halved on until the sum changes by less than 10⁻⁷ of the light of the
// piece, and of its depth: in front of something opaque, what is dark changes in its depth alone where it
// becomes clear.
#pragma once

#include <algorithm>
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

/// Gauss and Legendre's rule of three nodes.
struct ThreeNodes {
  static constexpr double offset = 0.38729833462074168852;  ///< of the outer ones from the middle: √0.6/2
  static constexpr double side = 5.0 / 18.0, middle = 8.0 / 18.0;
  double time[3];

  /// Of the shares of light from `a` to `b`.
  ThreeNodes(const LightOverTime& light, double a, double b)
      : time{light.time(a + (0.5 - offset) * (b - a)), light.time(0.5 * a + 0.5 * b),
             light.time(a + (0.5 + offset) * (b - a))} {}
};

/// ∫ at(time) ds over the shares of light from `first` to `last`, of what is above 0: by three nodes, in
/// halves where it varies by more than a hundredth of itself.
template <class At>
[[nodiscard]] double smooth_integral(const LightOverTime& light, double first, double last, const At& at,
                                     int halvings = 6) {
  const ThreeNodes nodes(light, first, last);
  const double a = at(nodes.time[0]), b = at(nodes.time[1]), c = at(nodes.time[2]);
  if (halvings > 0 && std::max({a, b, c}) - std::min({a, b, c}) > 0.01 * b) {
    const double half = 0.5 * first + 0.5 * last;
    return smooth_integral(light, first, half, at, halvings - 1) +
           smooth_integral(light, half, last, at, halvings - 1);
  }
  return (last - first) * (ThreeNodes::side * (a + c) + ThreeNodes::middle * b);
}

/// Adds ∫ at(time) ds over the shares of light from `first` to `last`. Calls part(a, b) for each stretch of
/// it that was summed up by its own nodes.
template <class At, class Part>
void add_light(double first, double last, const LightOverTime& light, const At& at, LightSum& sum,
               const Part& part) {
  struct Nodes {
    LightSum mean;
    bool uneven = false;
  };
  const auto nodes = [&](double a, double b) {
    const ThreeNodes at_nodes(light, a, b);
    const LightSum looks[3] = {at(at_nodes.time[0]), at(at_nodes.time[1]), at(at_nodes.time[2])};
    Nodes n;
    n.mean.add(looks[0], ThreeNodes::side);
    n.mean.add(looks[1], ThreeNodes::middle);
    n.mean.add(looks[2], ThreeNodes::side);
    for (int c = 0; c < 5; ++c) {
      const double spread =
          std::max(std::abs(looks[0].v[c] - looks[1].v[c]), std::abs(looks[2].v[c] - looks[1].v[c]));
      n.uneven = n.uneven || spread > 0x1p-10 * (c < 4 ? 1.0 : std::abs(n.mean.v[c]));
    }
    return n;
  };
  const auto refine = [&](const auto& self, double a, double b, const Nodes& whole, int halvings) -> void {
    if (halvings == 0 || !whole.uneven) {
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
    const double depth_off = std::abs(0.5 * left.mean.v[4] + 0.5 * right.mean.v[4] - whole.mean.v[4]);
    if (off <= 1e-7 * most && depth_off <= 1e-7 * std::abs(whole.mean.v[4])) {
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

}  // namespace swept
