// A hierarchy of boxes that move evenly over a stretch of time, over primitives of any kind.
//
// Source: US 8791945. A box is bounds at both ends of the stretch, in between their mean by time; a node's
// box is those of its children merged at either end. A build without SWEPT_HIERARCHY has none of this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "abuffer/stochastic/enclosure.h"

namespace swept::hierarchy {

struct MovingBox {
  Eigen::Array3d low[2], high[2];  ///< at the begin and the end of the stretch

  /// Contains nothing.
  [[nodiscard]] static MovingBox none() {
    const Eigen::Array3d most = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
    return {{most, most}, {-most, -most}};
  }
  void include(const MovingBox& other) {
    for (int end = 0; end < 2; ++end) {
      low[end] = low[end].min(other.low[end]);
      high[end] = high[end].max(other.high[end]);
    }
  }
  /// A point on a parabola with these control points, which leaves its chord by −¼ to 0 of its second
  /// difference.
  void include(const Eigen::Vector3d (&parabola)[3]);
  /// For the rounding of whoever computes with it.
  void widen();
};

/// The places of space that rays of a tile may come by: those that are not outside of any side. Outside of a
/// side is where all its planes have n·p > offset.
struct Frustum {
  struct Plane {
    Eigen::Vector3d normal;
    double offset;
  };
  struct Side {
    int count = 0;
    Plane plane[4];
  };
  Side side[5];
};

/// The stretch's part, [0, 1], in which the box may not be outside of the frustum (Eq. 1).
[[nodiscard]] stochastic::Span overlap(const MovingBox& box, const Frustum& frustum);

/// A ray o + z d, d = (x, y, 1), z ≥ near, with what does not depend on the box.
struct BoxRay {
  double from[2], inverse[2], near;
};
[[nodiscard]] BoxRay box_ray(double x, double y, double from_x, double from_y, double near);
/// Whether the ray may meet the box at a time of the stretch, [0, 1].
[[nodiscard]] bool meets(const MovingBox& box, double t, const BoxRay& ray);

class MovingBoxes {
 public:
  struct Node {
    std::uint32_t level = 0, index = 0;
  };
  /// What a tile may see of the hierarchy: when, and the lowest node that has all of it.
  struct Seen {
    stochastic::Span span{1.0, 0.0};
    Node branch;
  };

  MovingBoxes() = default;
  /// Over items, which are known by their indices. In parallel.
  explicit MovingBoxes(const std::vector<MovingBox>& items);

  [[nodiscard]] Seen seen(const Frustum& frustum, std::uint64_t& boxes_tested) const;
  /// visit(item) for all items below `start` in leaves whose box the ray may meet at that time.
  template <class Visit>
  void walk(const BoxRay& ray, double t, Node start, std::uint64_t& boxes_tested, const Visit& visit) const {
    Node stack[2 * most_levels];
    std::size_t depth = 0;
    stack[depth++] = start;
    while (depth > 0) {
      const Node node = stack[--depth];
      ++boxes_tested;
      if (!meets(levels_[node.level][node.index], t, ray)) continue;
      if (node.level == 0) {
        const std::size_t first = std::size_t{node.index} * leaf_items;
        for (std::size_t i = first; i < std::min(first + leaf_items, order_.size()); ++i) visit(order_[i]);
        continue;
      }
      const std::uint32_t child = 2 * node.index;
      if (child + 1 < levels_[node.level - 1].size()) stack[depth++] = {node.level - 1, child + 1};
      stack[depth++] = {node.level - 1, child};
    }
  }

  [[nodiscard]] bool empty() const { return order_.empty(); }
  [[nodiscard]] const std::vector<std::vector<MovingBox>>& levels() const { return levels_; }

 private:
  /// Four test ten times as many samples of a horse in vain, in the same time.
  static constexpr std::size_t leaf_items = 1, most_levels = 33;

  [[nodiscard]] Node root() const { return {static_cast<std::uint32_t>(levels_.size()) - 1, 0}; }

  std::vector<std::uint32_t> order_;  ///< items along a Morton curve
  std::vector<std::vector<MovingBox>>
      levels_;  ///< leaves first; node i is over 2i and 2i + 1 of the level below
};

}  // namespace swept::hierarchy
