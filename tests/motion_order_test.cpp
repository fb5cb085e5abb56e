// The order of points that move apart: packets stay small, and what they hold follows from the points.
#include "abuffer/sources/motion_order.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/simd/sampled_math.h"

namespace swept {
namespace {

constexpr auto packet = static_cast<std::size_t>(packet_size);

/// In a box, each with a velocity of its own, `apart` times the box long.
std::vector<PointEnds> cloud(std::size_t count, double apart) {
  std::mt19937 bits(7);
  const auto number = [&] { return static_cast<double>(bits()) * 0x1p-32; };
  std::vector<PointEnds> points(count);
  for (PointEnds& point : points)
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = number();
      point[axis + 3] = point[axis] + apart * (number() - 0.5);
    }
  return points;
}

std::vector<std::uint32_t> counted(std::size_t count) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

std::vector<std::uint32_t> ordered(const std::vector<PointEnds>& points, std::vector<std::uint32_t> order) {
  return motion_order(
      std::move(order), [&](std::uint32_t i) { return points[i]; },
      [](std::uint32_t, std::uint32_t) { return false; });
}

/// Of packets of sixteen, the sum of how wide they are at both ends.
double width(const std::vector<PointEnds>& points, const std::vector<std::uint32_t>& order) {
  double sum = 0.0;
  for (std::size_t first = 0; first < order.size(); first += packet) {
    PointEnds low = points[order[first]], high = low;
    for (std::size_t i = first; i < std::min(first + packet, order.size()); ++i) {
      low = low.cwiseMin(points[order[i]]);
      high = high.cwiseMax(points[order[i]]);
    }
    sum += (high - low).norm();
  }
  return sum;
}

/// Sixteen by sixteen along x in the middle, as a curve through space would have them.
std::vector<std::uint32_t> by_middle(const std::vector<PointEnds>& points) {
  std::vector<std::uint32_t> order = counted(points.size());
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return points[a][0] + points[a][3] < points[b][0] + points[b][3];
  });
  return order;
}

TEST(MotionOrder, KeepsPacketsSmall) {
  // Whose middles are all in one place, so that only where they go to tells them apart.
  std::vector<PointEnds> points = cloud(1000, 1.0);
  for (PointEnds& point : points) {
    const Eigen::Vector3d way = point.tail<3>() - point.head<3>();
    point << -way, way;
  }
  const std::vector<std::uint32_t> before = by_middle(points), after = ordered(points, before);
  EXPECT_LT(width(points, after), 0.6 * width(points, before));
  std::vector<std::uint32_t> all = after;
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, counted(points.size()));
}

TEST(MotionOrder, LeavesPointsThatStayTogether) {
  std::vector<PointEnds> points = cloud(1000, 0.0);
  for (PointEnds& point : points) point.tail<3>().array() += 5.0;
  const std::vector<std::uint32_t> order = by_middle(points);
  EXPECT_EQ(ordered(points, order), order);
}

TEST(MotionOrder, FollowsFromThePointsAlone) {
  const std::vector<PointEnds> points = cloud(777, 3.0);
  std::vector<std::uint32_t> shuffled = counted(points.size());
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(3));
  std::vector<PointEnds> moved;
  for (const std::uint32_t i : shuffled) moved.push_back(points[i]);
  const std::vector<std::uint32_t> a = ordered(points, by_middle(points)),
                                   b = ordered(moved, by_middle(moved));
  ASSERT_NE(a, by_middle(points));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(points[a[i]], moved[b[i]]);
}

}  // namespace
}  // namespace swept
