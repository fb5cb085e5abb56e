#include "abuffer/hierarchy/moving_boxes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "abuffer/parallel.h"

namespace swept::hierarchy {
namespace {

using stochastic::Span;

/// Every third bit, of 21.
std::uint64_t spread(std::uint64_t v) {
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

/// The plane's least value over the box at one end.
double least(const MovingBox& box, int end, const Frustum::Plane& plane) {
  double value = -plane.offset;
  for (int axis = 0; axis < 3; ++axis) {
    const double n = plane.normal[axis];
    value += n * (n > 0.0 ? box.low[end][axis] : box.high[end][axis]);
  }
  return value;
}

}  // namespace

void MovingBox::include(const Eigen::Vector3d (&p)[3]) {
  const Eigen::Array3d second = (p[0] - 2.0 * p[1] + p[2]).array();
  const Eigen::Array3d below = (-0.25 * second).min(0.0), above = (-0.25 * second).max(0.0);
  for (int end = 0; end < 2; ++end) {
    const Eigen::Array3d at = p[2 * end].array();
    low[end] = low[end].min(at + below);
    high[end] = high[end].max(at + above);
  }
}

void MovingBox::widen() {
  double largest = 0.0;
  for (int end = 0; end < 2; ++end)
    largest = std::max({largest, low[end].abs().maxCoeff(), high[end].abs().maxCoeff()});
  for (int end = 0; end < 2; ++end) {
    low[end] -= 1e-9 * largest;
    high[end] += 1e-9 * largest;
  }
}

Span overlap(const MovingBox& box, const Frustum& frustum) {
  Span span;
  for (const Frustum::Side& side : frustum.side) {
    Span within{1.0, 0.0};
    for (int i = 0; i < side.count; ++i) {
      // Linear in time, as the corner that is farthest inside is the same one throughout.
      const double begin = least(box, 0, side.plane[i]), end = least(box, 1, side.plane[i]);
      if (begin <= 0.0 && end <= 0.0) {
        within = {0.0, 1.0};
        break;
      }
      if (begin > 0.0 && end > 0.0) continue;
      const double crossing = begin / (begin - end);
      within = stochastic::join(within, begin <= 0.0 ? Span{0.0, crossing} : Span{crossing, 1.0});
    }
    span = stochastic::meet(span, within);
    if (span.empty()) break;
  }
  return span;
}

BoxRay box_ray(double x, double y, double from_x, double from_y, double near) {
  // A ray along an axis is infinitely far within a slab, or never.
  const auto inverse = [](double v) { return std::abs(v) > 1e-30 ? 1.0 / v : 1e30; };
  return {{from_x, from_y}, {inverse(x), inverse(y)}, near};
}

bool meets(const MovingBox& box, double t, const BoxRay& ray) {
  const auto at = [t](double a, double b) { return a + t * (b - a); };
  double begin = std::max(ray.near * (1.0 - 1e-9), at(box.low[0].z(), box.low[1].z())),
         end = at(box.high[0].z(), box.high[1].z());
  for (int axis = 0; axis < 2; ++axis) {
    double a = (at(box.low[0][axis], box.low[1][axis]) - ray.from[axis]) * ray.inverse[axis],
           b = (at(box.high[0][axis], box.high[1][axis]) - ray.from[axis]) * ray.inverse[axis];
    if (a > b) std::swap(a, b);
    // As much as three roundings; boxes are widened besides.
    begin = std::max(begin, a - 1e-12 * std::abs(a));
    end = std::min(end, b + 1e-12 * std::abs(b));
  }
  return begin <= end;
}

MovingBoxes::MovingBoxes(const std::vector<MovingBox>& items) {
  if (items.empty()) return;
  MovingBox all = MovingBox::none();
  for (const MovingBox& item : items) all.include(item);
  const Eigen::Array3d low = all.low[0].min(all.low[1]), size = all.high[0].max(all.high[1]) - low;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> codes(items.size());
  parallel_for_each_index(items.size(), [&](std::size_t i) {
    const MovingBox& item = items[i];
    const Eigen::Array3d middle = 0.25 * (item.low[0] + item.low[1] + item.high[0] + item.high[1]);
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double share = size[axis] > 0.0 ? (middle[axis] - low[axis]) / size[axis] : 0.0;
      const double cell = std::isfinite(share) ? std::clamp(share * 2097151.0, 0.0, 2097151.0) : 0.0;
      code |= spread(static_cast<std::uint64_t>(cell)) << axis;
    }
    codes[i] = {code, static_cast<std::uint32_t>(i)};
  });
  std::sort(codes.begin(), codes.end());
  order_.reserve(codes.size());
  for (const auto& [code, item] : codes) order_.push_back(item);

  levels_.emplace_back((items.size() + leaf_items - 1) / leaf_items);
  parallel_for_each_index(levels_[0].size(), [&](std::size_t node) {
    MovingBox box = MovingBox::none();
    for (std::size_t i = node * leaf_items; i < std::min((node + 1) * leaf_items, order_.size()); ++i)
      box.include(items[order_[i]]);
    box.widen();
    levels_[0][node] = box;
  });
  while (levels_.back().size() > 1) {
    const std::size_t below = levels_.size() - 1;
    levels_.emplace_back((levels_[below].size() + 1) / 2);
    const std::vector<MovingBox>& children = levels_[below];
    parallel_for_each_index(levels_.back().size(), [&](std::size_t node) {
      MovingBox box = children[2 * node];
      if (2 * node + 1 < children.size()) box.include(children[2 * node + 1]);
      levels_.back()[node] = box;
    });
  }
}

MovingBoxes::Seen MovingBoxes::seen(const Frustum& frustum, std::uint64_t& boxes_tested) const {
  Seen seen;
  if (empty()) return seen;
  // Of the leaves that are seen, the first and the last: the branch is the lowest node over both.
  std::uint32_t first = 0, last = 0;
  bool any = false;
  Node stack[2 * most_levels];
  std::size_t depth = 0;
  stack[depth++] = root();
  while (depth > 0) {
    const Node node = stack[--depth];
    ++boxes_tested;
    const Span span = overlap(levels_[node.level][node.index], frustum);
    if (span.empty()) continue;
    if (node.level == 0) {
      seen.span = stochastic::join(seen.span, span);
      if (!any) first = node.index;
      last = node.index;  // children are visited in their order
      any = true;
      continue;
    }
    const std::uint32_t child = 2 * node.index;
    if (child + 1 < levels_[node.level - 1].size()) stack[depth++] = {node.level - 1, child + 1};
    stack[depth++] = {node.level - 1, child};
  }
  while (first != last) first >>= 1, last >>= 1, ++seen.branch.level;
  seen.branch.index = first;
  return seen;
}

}  // namespace swept::hierarchy
