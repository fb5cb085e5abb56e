// Where in depth the light of pieces of time comes from, by the nodes that their light is summed up with.
// Source: model section 19.
#pragma once

#include "abuffer/resolve/place_light.h"

namespace swept {

/// Calls node(time, weight, begin, end) for each node of the shares of light from `first` to `last`: what is
/// seen at `time` stands for so much of the light, and for what is seen from `begin` to `end`.
template <class Node>
void for_each_node(double first, double last, const LightOverTime& light, const Node& node) {
  constexpr double weights[] = {ThreeNodes::side, ThreeNodes::middle, ThreeNodes::side};
  const ThreeNodes nodes(light, first, last);
  const auto time = [&](double at) { return light.time(first + at * (last - first)); };
  double begin = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double end = k < 2 ? begin + weights[k] : 1.0;
    node(nodes.time[k], weights[k] * (last - first), time(begin), time(end));
    begin = end;
  }
}

}  // namespace swept
