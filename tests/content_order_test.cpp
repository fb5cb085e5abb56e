// The order of points that their places give them.
#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/sources/content_order.h"

namespace swept {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points ordered(const Points& points) {
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    return std::lexicographical_compare(points[a].data(), points[a].data() + 3, points[b].data(),
                                        points[b].data() + 3);
  };
  Points found;
  for (const std::uint32_t i : content_order(
           points.size(), [&](std::size_t i) { return points[i]; }, less))
    found.push_back(points[i]);
  return found;
}

TEST(ContentOrder, NeverJumpsAlongItsCurve) {
  // In the middles of eighths of the range, a whole cube of them; the corners make the range.
  Points points{{0, 0, 0}, {16, 16, 16}};
  for (int i = 0; i < 16 * 16 * 16; ++i) points.emplace_back(i % 16 + 0.5, i / 16 % 16 + 0.5, i / 256 + 0.5);
  const Points found = ordered(points);
  ASSERT_EQ(found.size(), points.size());
  int steps = 0;
  for (std::size_t i = 1; i < found.size(); ++i) {
    const double step = (found[i] - found[i - 1]).cwiseAbs().sum();
    // But for the corners.
    if (step != 1.0)
      EXPECT_TRUE(found[i].maxCoeff() == 16.0 || found[i - 1].maxCoeff() == 0.0 ||
                  found[i - 1].maxCoeff() == 16.0 || found[i].maxCoeff() == 0.0)
          << i << ": " << step;
    steps += step == 1.0 ? 1 : 0;
  }
  EXPECT_GE(steps, 16 * 16 * 16 - 3);
}

TEST(ContentOrder, FollowsFromThePointsAlone) {
  std::mt19937 bits(5);
  Points points;
  // More than a run of the sort, many of them in one cell and some equal.
  for (int i = 0; i < 300'000; ++i) {
    const double x = bits() % 1000, y = bits() % 1000, z = bits() % 7;
    const double size = i % 3 == 0 ? 1e-9 : 1.0;
    points.emplace_back(size * x, size * y, size * z);
  }
  const Points found = ordered(points);
  std::shuffle(points.begin(), points.end(), bits);
  EXPECT_EQ(ordered(points), found);
  // Each once.
  const auto less = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  Points sorted = found;
  std::sort(sorted.begin(), sorted.end(), less);
  std::sort(points.begin(), points.end(), less);
  EXPECT_EQ(sorted, points);
}

TEST(ContentOrder, TakesAnyRange) {
  EXPECT_TRUE(ordered({}).empty());
  EXPECT_EQ(ordered({{1, 2, 3}}).size(), 1u);
  const double most = 1.7e308, least = 5e-324;
  const Points wide{{most, 0, 0}, {-most, 0, 0}, {0, most, 0}};
  EXPECT_EQ(ordered(wide).size(), 3u);
  const Points narrow{{0, 0, least}, {least, 0, 0}, {0, 0, 0}};
  EXPECT_EQ(ordered(narrow), Points({{0, 0, 0}, {0, 0, least}, {least, 0, 0}}));
}

}  // namespace
}  // namespace swept
