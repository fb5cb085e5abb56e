#include "abuffer/resolve/alone.h"

#include <algorithm>
#include <numeric>

namespace swept {
namespace {

constexpr double root_three = 1.7320508075688772;

/// Where on [0, 1] Gauss's two points are.
constexpr double gauss_points[2] = {0.5 - 0.5 / root_three, 0.5 + 0.5 / root_three};

/// A time on [0, 1] of the piece in units of the points' distance from its middle.
double sign_at(double time) { return (2.0 * time - 1.0) * root_three; }

double value(const AloneLayer& layer, int channel, double sign) {
  return layer.mean[channel] + sign * layer.swing[channel];
}
double depth(const AloneLayer& layer, double time) {
  return layer.z_begin + time * (double{layer.z_end} - layer.z_begin);
}

}  // namespace

void AloneStack::composite(double duration, PixelSum& pixel) {
  const std::size_t count = layers.size();
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  position_ = order_;
  for (int point = 0; point < 2; ++point) {
    light_[point].resize(count + 1);
    double left = 1.0;
    for (std::size_t i = 0; i < count; ++i) {
      light_[point][i] = left;
      const double sign = 2 * point - 1, share = 0.5 * duration * left, alpha = value(layers[i], 3, sign);
      for (int c = 0; c < 4; ++c) pixel.rgba[c] += share * value(layers[i], c, sign);
      pixel.depth += share * alpha * depth(layers[i], gauss_points[point]);
      if (pixel.by_depth != nullptr) {
        double rgba[4];
        for (int c = 0; c < 4; ++c) rgba[c] = share * value(layers[i], c, sign);
        pixel.by_depth->add(depth(layers[i], 0.5 * point), depth(layers[i], 0.5 + 0.5 * point), rgba);
      }
      left *= 1.0 - alpha;
    }
    light_[point][count] = left;
  }
  find_swaps();
  // Those that meet in one point come in any order, and some have to wait until they are neighbours.
  waiting_.clear();
  for (const Swap& crossing : swaps_) {
    if (!swap(crossing, duration, pixel)) {
      waiting_.push_back(crossing);
      continue;
    }
    for (bool any = true; any && !waiting_.empty();) {
      any = false;
      for (std::size_t i = 0; i < waiting_.size(); ++i) {
        if (!swap(waiting_[i], duration, pixel)) continue;
        waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
        any = true;
        break;
      }
    }
  }
}

/// By sorting as the piece ends: every move is a crossing.
void AloneStack::find_swaps() {
  swaps_.clear();
  for (std::size_t i = 1; i < layers.size(); ++i) {
    const std::uint32_t layer = order_[i];
    std::size_t k = i;
    for (; k > 0 && layers[order_[k - 1]].z_end > layers[layer].z_end; --k) {
      const AloneLayer &a = layers[order_[k - 1]], &b = layers[layer];
      const double before = double{b.z_begin} - a.z_begin, after = double{a.z_end} - b.z_end;
      swaps_.push_back({before / (before + after), order_[k - 1], layer});
      order_[k] = order_[k - 1];
    }
    order_[k] = layer;
  }
  std::iota(order_.begin(), order_.end(), 0u);
  std::sort(swaps_.begin(), swaps_.end(), [](const Swap& a, const Swap& b) {
    if (a.time != b.time) return a.time < b.time;
    return a.before != b.before ? a.before < b.before : a.behind < b.behind;
  });
}

/// Changes what the two give from their crossing on. False if they are not neighbours.
bool AloneStack::swap(const Swap& crossing, double duration, PixelSum& pixel) {
  const std::uint32_t at = position_[crossing.before];
  if (position_[crossing.behind] != at + 1) return false;
  const AloneLayer &a = layers[crossing.before], &b = layers[crossing.behind];
  const double rest = 1.0 - crossing.time;
  for (int half = 0; half < 2; ++half) {
    const double point = gauss_points[half];
    const double time = crossing.time + rest * point, sign = sign_at(time);
    const double light = 0.5 * (light_[0][at] + light_[1][at]) + 0.5 * sign * (light_[1][at] - light_[0][at]);
    const double share = 0.5 * duration * rest * light, of_a = value(a, 3, sign), of_b = value(b, 3, sign);
    // a + (1 − α)b becomes b + (1 − β)a.
    for (int c = 0; c < 3; ++c)
      pixel.rgba[c] += share * (of_a * value(b, c, sign) - of_b * value(a, c, sign));
    pixel.depth += share * of_a * of_b * (depth(b, time) - depth(a, time));
    if (pixel.by_depth != nullptr) {
      const double from = crossing.time + 0.5 * half * rest, to = from + 0.5 * rest;
      double less[4], more[4];
      for (int c = 0; c < 4; ++c) {
        less[c] = -share * of_b * value(a, c, sign);
        more[c] = share * of_a * value(b, c, sign);
      }
      pixel.by_depth->add(depth(a, from), depth(a, to), less);
      pixel.by_depth->add(depth(b, from), depth(b, to), more);
    }
  }
  for (int point = 0; point < 2; ++point)
    light_[point][at + 1] = light_[point][at] * (1.0 - value(b, 3, 2 * point - 1));
  std::swap(order_[at], order_[at + 1]);
  position_[crossing.before] = at + 1;
  position_[crossing.behind] = at;
  return true;
}

}  // namespace swept
