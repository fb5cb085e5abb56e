#include "abuffer/sources/motion_order.h"

#include <algorithm>

#include "abuffer/simd/sampled_math.h"

namespace swept {
namespace {

constexpr auto packet = static_cast<std::size_t>(packet_size);

struct MovingPoint {
  PointEnds at;
  std::uint32_t index;
};

struct Spread {
  PointEnds low, high;

  explicit Spread(const MovingPoint& point) : low(point.at), high(point.at) {}
  void add(const MovingPoint& point) {
    low = low.cwiseMin(point.at);
    high = high.cwiseMax(point.at);
  }
  [[nodiscard]] PointEnds range() const { return 0.5 * high - 0.5 * low; }
};

Spread spread_of(const MovingPoint* begin, const MovingPoint* end) {
  Spread spread(*begin);
  for (const MovingPoint* point = begin; point != end; ++point) spread.add(*point);
  return spread;
}

/// How large packets are at either end, and how large they are in the middle.
bool come_apart(const std::vector<MovingPoint>& points) {
  double at_ends = 0.0, between = 0.0;
  for (std::size_t first = 0; first < points.size(); first += packet) {
    const std::size_t last = std::min(first + packet, points.size());
    at_ends += spread_of(points.data() + first, points.data() + last).range().norm();
    const auto middle = [&](std::size_t i) -> Eigen::Vector3d {
      return 0.5 * points[i].at.head<3>() + 0.5 * points[i].at.tail<3>();
    };
    Eigen::Vector3d low = middle(first), high = low;
    for (std::size_t i = first + 1; i < last; ++i) {
      low = low.cwiseMin(middle(i));
      high = high.cwiseMax(middle(i));
    }
    between += (0.5 * high - 0.5 * low).norm();
  }
  // Those that stay together are √2 times as large at two ends as in the middle.
  return at_ends > 1.5 * between;
}

template <class Less>
void halve(MovingPoint* begin, MovingPoint* end, const Less& less) {
  const auto count = static_cast<std::size_t>(end - begin);
  if (count <= packet) return;
  int axis = 0;
  spread_of(begin, end).range().maxCoeff(&axis);
  // Whole packets before the middle.
  const std::size_t packets = (count + packet - 1) / packet;
  MovingPoint* const middle = begin + (packets / 2) * packet;
  std::nth_element(begin, middle, end, [&](const MovingPoint& a, const MovingPoint& b) {
    return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : less(a.index, b.index);
  });
  halve(begin, middle, less);
  halve(middle, end, less);
}

}  // namespace

std::vector<std::uint32_t> motion_order(std::vector<std::uint32_t> order,
                                        const std::function<PointEnds(std::uint32_t)>& ends,
                                        const std::function<bool(std::uint32_t, std::uint32_t)>& less) {
  // Beyond this many points are close enough together for it to cost more than it saves.
  constexpr std::size_t most = 100'000;
  if (order.size() <= packet || order.size() > most) return order;
  std::vector<MovingPoint> points;
  points.reserve(order.size());
  for (const std::uint32_t index : order) points.push_back({ends(index), index});
  if (!come_apart(points)) return order;
  halve(points.data(), points.data() + points.size(), less);
  // Within a packet the order has to follow from the points, too.
  for (std::size_t first = 0; first < points.size(); first += packet)
    std::sort(points.begin() + static_cast<std::ptrdiff_t>(first),
              points.begin() + static_cast<std::ptrdiff_t>(std::min(first + packet, points.size())),
              [&](const MovingPoint& a, const MovingPoint& b) {
                for (int axis = 0; axis < 6; ++axis)
                  if (a.at[axis] != b.at[axis]) return a.at[axis] < b.at[axis];
                return less(a.index, b.index);
              });
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = points[i].index;
  return order;
}

}  // namespace swept
