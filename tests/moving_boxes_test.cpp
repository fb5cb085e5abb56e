// The hierarchy of moving boxes contains: by dense sampling, a tile's time and a ray's walk miss nothing.
#include "abuffer/hierarchy/moving_boxes.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/small_scenes.h"

namespace swept::hierarchy {
namespace {

struct Parabola {
  Eigen::Vector3d p[3];

  [[nodiscard]] Eigen::Vector3d at(double t) const {
    return (1 - t) * (1 - t) * p[0] + 2 * t * (1 - t) * p[1] + t * t * p[2];
  }
};

std::vector<Parabola> parabolas(int count, unsigned seed) {
  test::Random random(seed);
  std::vector<Parabola> all;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d middle(random(-3, 3), random(-3, 3), random(-1, 8));
    Parabola parabola;
    for (Eigen::Vector3d& p : parabola.p) p = middle + random.vector(-0.5, 0.5);
    all.push_back(parabola);
  }
  return all;
}

std::vector<MovingBox> boxes_of(const std::vector<Parabola>& all) {
  std::vector<MovingBox> boxes(all.size(), MovingBox::none());
  for (std::size_t i = 0; i < all.size(); ++i) boxes[i].include(all[i].p);
  return boxes;
}

TEST(MovingBoxes, ContainWhatMovesOnParabolas) {
  const std::vector<Parabola> all = parabolas(300, 1);
  const std::vector<MovingBox> boxes = boxes_of(all);
  for (std::size_t i = 0; i < all.size(); ++i)
    for (int k = 0; k <= 100; ++k) {
      const double t = k / 100.0;
      const Eigen::Array3d p = all[i].at(t).array(), low = (1 - t) * boxes[i].low[0] + t * boxes[i].low[1],
                           high = (1 - t) * boxes[i].high[0] + t * boxes[i].high[1];
      ASSERT_TRUE((p >= low - 1e-12).all() && (p <= high + 1e-12).all()) << i << ' ' << t;
    }
}

/// The pyramid of places with |x|, |y| ≤ w z about a direction.
Frustum pyramid(double x, double y, double w) {
  Frustum frustum;
  for (int axis = 0; axis < 2; ++axis) {
    const double middle = axis == 0 ? x : y;
    for (const double sign : {-1.0, 1.0}) {
      Eigen::Vector3d normal(0, 0, -sign * (middle + sign * w));
      normal[axis] = sign;
      Frustum::Side& side = frustum.side[2 * axis + (sign > 0)];
      side.plane[side.count++] = {normal, 0.0};
    }
  }
  frustum.side[4].plane[frustum.side[4].count++] = {{0, 0, -1}, -0.1};
  return frustum;
}

TEST(MovingBoxes, TellTilesWhenToLookAndFromWhere) {
  test::Random random(4);
  for (const int count : {1, 3, 4, 5, 37, 1000}) {
    const std::vector<Parabola> all = parabolas(count, 2);
    const MovingBoxes tree(boxes_of(all));
    std::size_t within = 0, looks = 0, of_root = 0;
    for (int trial = 0; trial < 200; ++trial) {
      const double x = random(-1, 1), y = random(-1, 1), w = random(0.001, 0.1);
      std::uint64_t tested = 0;
      const MovingBoxes::Seen seen = tree.seen(pyramid(x, y, w), tested);
      looks += !seen.span.empty();
      of_root += !seen.span.empty() && seen.branch.level + 1 == tree.levels().size();
      for (std::size_t i = 0; i < all.size(); ++i)
        for (int k = 0; k <= 50; ++k) {
          const double t = k / 50.0;
          const Eigen::Vector3d p = all[i].at(t);
          if (p.z() < 0.1 || std::abs(p.x() - x * p.z()) > w * p.z() ||
              std::abs(p.y() - y * p.z()) > w * p.z())
            continue;
          ++within;
          ASSERT_GE(t, seen.span.begin - 1e-12);
          ASSERT_LE(t, seen.span.end + 1e-12);
          // The ray through it, from the branch.
          bool visited = false;
          tree.walk(box_ray(p.x() / p.z(), p.y() / p.z(), 0.0, 0.0, 0.1), t, seen.branch, tested,
                    [&](std::uint32_t item) { visited = visited || item == i; });
          ASSERT_TRUE(visited) << count << ' ' << i << ' ' << t;
        }
    }
    if (count < 1000) continue;
    EXPECT_GT(within, 1000u);
    EXPECT_LT(of_root, looks) << "no branch is below the root";
  }
}

TEST(MovingBoxes, MeetRaysThatRunAlongAxes) {
  MovingBox box{{{-1, -1, 1}, {-1, -1, 1}}, {{1, 1, 2}, {1, 1, 2}}};
  box.widen();
  EXPECT_TRUE(meets(box, 0.5, box_ray(0, 0, 0, 0, 0.1)));
  EXPECT_TRUE(meets(box, 0.5, box_ray(0, 0, 1, -1, 0.1)));
  EXPECT_FALSE(meets(box, 0.5, box_ray(0, 0, 1.1, 0, 0.1)));
  EXPECT_FALSE(meets(box, 0.5, box_ray(0, 0, 0, 0, 2.1)));
  EXPECT_FALSE(meets(box, 0.5, box_ray(1.1, 0, 0, 0, 0.1)));
}

TEST(MovingBoxes, OfNothingAreEmpty) {
  std::uint64_t tested = 0;
  EXPECT_TRUE(MovingBoxes(std::vector<MovingBox>{}).seen(pyramid(0, 0, 1), tested).span.empty());
}

}  // namespace
}  // namespace swept::hierarchy
