#include "splat/motion/path.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace swept {
namespace {

/// A cubic c₀ + c₁t + c₂t² + c₃t³ for each of the keys that have a share in a stretch.
struct KeyCubic {
  std::size_t key;
  std::array<double, 4> c{};
};

/// Adds `scale` times the velocity of the spline at key `k`, as weights of keys, to out(key, weight).
template <class Out>
void add_tangent(const std::vector<SurfelKey>& keys, std::size_t k, double scale, const Out& out) {
  const std::size_t last = keys.size() - 1;
  const auto slope = [&](std::size_t j, double weight) {  // of the chord from j to j + 1
    const double per_frame = weight / (keys[j + 1].frame - keys[j].frame);
    out(j, -per_frame);
    out(j + 1, per_frame);
  };
  if (last == 1) return slope(0, scale);
  const std::size_t inner = std::clamp<std::size_t>(k, 1, last - 1);
  const double before = keys[inner].frame - keys[inner - 1].frame,
               after = keys[inner + 1].frame - keys[inner].frame, sum = before + after;
  // The parabola through three keys: its velocity at a key is twice the chord's less that at the other end.
  if (k == inner) {
    slope(inner - 1, scale * after / sum);
    slope(inner, scale * before / sum);
  } else {
    const std::size_t chord = k < inner ? inner - 1 : inner;
    slope(chord, 2.0 * scale);
    slope(inner - 1, -scale * after / sum);
    slope(inner, -scale * before / sum);
  }
}

/// The spline from key j to j + 1 over t in [0, 1], relative to key j.
std::vector<KeyCubic> spline_stretch(const std::vector<SurfelKey>& keys, std::size_t j) {
  std::vector<KeyCubic> cubics;
  const std::size_t first = j > 0 ? j - 1 : 0, last = std::min(j + 2, keys.size() - 1);
  for (std::size_t k = first; k <= last; ++k) cubics.push_back({k, {}});
  const auto add = [&](std::size_t key, const std::array<double, 4>& basis, double weight) {
    for (KeyCubic& cubic : cubics)
      if (cubic.key == key)
        for (std::size_t i = 0; i < 4; ++i) cubic.c[i] += weight * basis[i];
  };
  const double length = keys[j + 1].frame - keys[j].frame;
  add(j + 1, {0.0, 0.0, 3.0, -2.0}, 1.0);
  add_tangent(keys, j, length, [&](std::size_t k, double w) { add(k, {0.0, 1.0, -2.0, 1.0}, w); });
  add_tangent(keys, j + 1, length, [&](std::size_t k, double w) { add(k, {0.0, 0.0, -1.0, 1.0}, w); });
  std::erase_if(cubics, [&](const KeyCubic& cubic) { return cubic.key == j; });
  return cubics;
}

/// The key that the stretch of `within` begins at; at a key the stretch before it.
std::size_t stretch_of(const std::vector<SurfelKey>& keys, double within) {
  const auto at = std::lower_bound(keys.begin(), keys.end(), within,
                                   [](const SurfelKey& key, double f) { return key.frame < f; });
  return std::clamp<std::size_t>(static_cast<std::size_t>(at - keys.begin()), 1, keys.size() - 1) - 1;
}

PathWeights bezier_blossom(const std::vector<SurfelKey>& keys, std::span<const double> frames) {
  const std::size_t degree = keys.size() - 1;
  const double first = keys.front().frame, length = keys.back().frame - first;
  // De Casteljau's triangle, of weights in place of points.
  std::vector<std::vector<double>> points(degree + 1, std::vector<double>(degree + 1, 0.0));
  for (std::size_t k = 0; k <= degree; ++k) points[k][k] = 1.0;
  for (std::size_t level = 0; level < degree; ++level) {
    const double t = (frames[level] - first) / length;
    for (std::size_t k = 0; k + level < degree; ++k)
      for (std::size_t i = 0; i <= degree; ++i)
        points[k][i] = (1.0 - t) * points[k][i] + t * points[k + 1][i];
  }
  PathWeights weights;
  for (std::size_t k = 1; k <= degree; ++k) weights.others.push_back({k, points[0][k]});
  return weights;
}

PathWeights spline_blossom(const std::vector<SurfelKey>& keys, double within, std::span<const double> f) {
  const std::size_t j = stretch_of(keys, within);
  const double first = keys[j].frame, length = keys[j + 1].frame - first;
  const double a = (f[0] - first) / length, b = (f[1] - first) / length, c = (f[2] - first) / length;
  const std::array<double, 4> means{1.0, (a + b + c) / 3.0, (a * b + b * c + c * a) / 3.0, a * b * c};
  PathWeights weights;
  weights.base = j;
  for (const KeyCubic& cubic : spline_stretch(keys, j)) {
    double weight = 0.0;
    for (std::size_t i = 0; i < 4; ++i) weight += cubic.c[i] * means[i];
    weights.others.push_back({cubic.key, weight});
  }
  return weights;
}

/// Straight lines between keys need no curve of a higher degree, nor do two keys.
bool straight(const SurfelCloud& cloud) { return cloud.path == KeyPath::linear || cloud.keys.size() == 2; }

}  // namespace

std::size_t path_degree(const SurfelCloud& cloud) {
  if (cloud.keys.size() < 2) return cloud.accelerates() ? 2 : 1;
  if (straight(cloud)) return 1;
  return cloud.path == KeyPath::spline ? 3 : cloud.keys.size() - 1;
}

PathWeights path_blossom(const SurfelCloud& cloud, double within, std::span<const double> frames) {
  const std::vector<SurfelKey>& keys = cloud.keys;
  PathWeights weights;
  if (keys.size() == 1) {
    double sum = 0.0, product = 1.0;
    for (const double frame : frames) {
      sum += frame - keys.front().frame;
      product *= frame - keys.front().frame;
    }
    weights.velocity = weights.elapsed = sum / static_cast<double>(frames.size());
    weights.acceleration = frames.size() == 2 ? 0.5 * product : 0.0;
    return weights;
  }
  if (straight(cloud)) {
    weights.base = stretch_of(keys, within);
    const double first = keys[weights.base].frame, length = keys[weights.base + 1].frame - first;
    weights.others.push_back({weights.base + 1, (frames[0] - first) / length});
    return weights;
  }
  return cloud.path == KeyPath::spline ? spline_blossom(keys, within, frames) : bezier_blossom(keys, frames);
}

PathWeights path_weights(const SurfelCloud& cloud, double frame) {
  const std::vector<SurfelKey>& keys = cloud.keys;
  PathWeights weights;
  if (keys.size() == 1) {
    weights.velocity = weights.elapsed = frame - keys.front().frame;
    weights.acceleration = 0.5 * weights.elapsed * weights.elapsed;
    return weights;
  }
  const auto after = std::upper_bound(keys.begin(), keys.end(), frame,
                                      [](double f, const SurfelKey& key) { return f < key.frame; });
  if (after == keys.begin()) return weights;
  if (after == keys.end()) {
    weights.base = keys.size() - 1;
    return weights;
  }
  if (straight(cloud)) {
    weights.base = static_cast<std::size_t>(after - keys.begin()) - 1;
    const double t = (frame - (after - 1)->frame) / (after->frame - (after - 1)->frame);
    weights.others.push_back({weights.base + 1, t});
    return weights;
  }
  const std::vector<double> same(path_degree(cloud), frame);
  return path_blossom(cloud, 0.5 * (after - 1)->frame + 0.5 * after->frame, same);
}

std::vector<PathWeights> path_controls(const SurfelCloud& cloud, double first, double last) {
  const std::size_t degree = path_degree(cloud);
  if (degree == 1) return {path_weights(cloud, first), path_weights(cloud, last)};
  std::vector<PathWeights> controls;
  const bool held =
      cloud.keys.size() > 1 && (last <= cloud.keys.front().frame || first >= cloud.keys.back().frame);
  std::vector<double> frames(degree, first);
  for (std::size_t k = 0; k <= degree; ++k) {
    if (k > 0) frames[k - 1] = last;
    controls.push_back(held ? path_weights(cloud, first)
                            : path_blossom(cloud, 0.5 * first + 0.5 * last, frames));
  }
  return controls;
}

std::vector<double> path_corners(const SurfelCloud& cloud, double first, double last) {
  std::vector<double> corners;
  if (cloud.keys.size() < 2) return corners;
  const bool only_ends = cloud.path == KeyPath::bezier;
  for (std::size_t k = 0; k < cloud.keys.size(); ++k) {
    if (only_ends && k > 0 && k + 1 < cloud.keys.size()) continue;
    const double frame = cloud.keys[k].frame;
    if (frame > first && frame < last) corners.push_back(frame);
  }
  return corners;
}

}  // namespace swept
