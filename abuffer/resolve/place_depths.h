// Where in depth the light of pieces of time comes from, by the nodes that their light is summed up with.
// Source: model section 19.
#pragma once

#include <span>
#include <vector>

#include "abuffer/resolve/place_light.h"
#include "splat/interval/depth_sum.h"

namespace swept {

/// Calls node(time, weight, begin, end) for each node of the shares of light from `first` to `last`: what is
/// seen at `time` stands for so much of the light, and for what is seen from `begin` to `end`.
template <class Node>
void for_each_node(double first, double last, const LightOverTime& light, const Node& node) {
  const auto time = [&](double at) { return light.time(first + at * (last - first)); };
  double begin = 0.0;
  for (const LightNode& n : light_nodes) {
    const double end = begin + n.weight;
    node(time(n.at), n.weight * (last - first), time(begin), time(end < 1.0 ? end : 1.0));
    begin = end;
  }
}

/// Of what light_at() sees, `scale` of the pixel.
inline void add_depths(std::span<const std::uint32_t> seen, const std::vector<TriangleStretch>& triangles,
                       const Eigen::Vector3d& ray, const LightOverTime& light, double first, double last,
                       double scale, DepthSum& by_depth) {
  for_each_node(first, last, light, [&](double time, double weight, double begin, double end) {
    double left = scale * weight;
    for (const std::uint32_t t : seen) {
      const TriangleStretch::Look look = triangles[t].look(ray, time);
      double rgba[4];
      for (int c = 0; c < 4; ++c) rgba[c] = left * look.rgba[c];
      by_depth.add(triangles[t].look(ray, begin).depth, triangles[t].look(ray, end).depth, rgba);
      left *= 1.0 - look.rgba[3];
      if (left < double{opaque_transmittance} * scale * weight) break;
    }
  });
}

}  // namespace swept
