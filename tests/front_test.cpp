// What is said of a front over a piece of time: by how little its weight may be wrong, and how far its
// members may differ.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/resolve/members.h"
#include "abuffer/simd/interval_math.h"
#include "splat/kernel/kernel_integral.h"

namespace swept {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

struct Streak {
  double from, to, y, rate, peak;
  float red = 0.5f;

  [[nodiscard]] double weight(double time) const {
    const double at = y + rate * (time - from);
    return time < from || time > to ? 0.0 : peak * std::exp(-at * at);
  }
};

MemberSet members_of(const std::vector<Streak>& streaks) {
  MemberSet members;
  FragmentArrays arrays;
  for (const Streak& s : streaks) {
    arrays.ensure(1);
    arrays.t_begin[0] = ticks_of(s.from);
    arrays.t_end[0] = ticks_of(s.to);
    arrays.y[0] = static_cast<float>(s.y);
    arrays.rate[0] = static_cast<float>(s.rate);
    arrays.peak[0] = static_cast<float>(s.peak);
    arrays.z[0] = 3.0f;
    arrays.z_rate[0] = 0.0f;
    members.push(arrays, 0, {{s.red, 0.5f, 0.5f, 1.0f}, 0.05f});
  }
  return members;
}

/// Streaks of one depth and like colours, the piece somewhere among them.
TEST(Front, WeighsNowhereLessThanItSays) {
  Random random(11);
  const IntervalMath math = interval_math_builds().back();
  int looked_at = 0, closer = 0, shown = 0;
  for (int i = 0; i < 5000; ++i) {
    std::vector<Streak> streaks(3 + random() % 30);
    for (Streak& s : streaks) {
      s.rate = uniform(random, 1.0, 6.0);
      s.y = uniform(random, -1.7, 0.0);
      s.from = uniform(random, 0.0, 0.6);
      s.to = std::min(s.from + uniform(random, 0.1, 3.4) / s.rate, 0.99);
      s.peak = uniform(random, 0.1, 1.0);
    }
    const MemberSet members = members_of(streaks);
    const double from = uniform(random, 0.2, 0.5), to = from + uniform(random, 0.01, 0.2);
    Members view = members.view();
    const FrontSum plain = math.front_over(view, ticks_of(from), ticks_of(to));
    view.enough = std::numeric_limits<float>::infinity();
    const FrontSum front = math.front_over(view, ticks_of(from), ticks_of(to));
    if (front.settled_until != ticks_of(to)) continue;
    ++looked_at;
    double least = std::numeric_limits<double>::infinity(), within = 0.0;
    for (int step = 0; step <= 400; ++step) {
      const double time = from + (to - from) * (1e-6 + step * (1.0 - 2e-6) / 400);
      double weight = 0.0;
      for (const Streak& s : streaks) weight += s.weight(time);
      least = std::min(least, weight);
      within += weight / 401;
    }
    ASSERT_LE(front.low, least * (1.0 + 1e-5) + 1e-6) << i;
    ASSERT_GE(front.low, plain.low);
    if (front.low > plain.low) ++closer;
    if (front.low > 0.5 * least) ++shown;
    ASSERT_NEAR(front.mean.weight, within, 0.02 * within + 0.02) << i;
  }
  // Of use, too: it often says more than the first bound, and mostly half of what is so.
  EXPECT_GT(looked_at, 1000);
  EXPECT_GT(closer, looked_at / 2);
  EXPECT_GT(shown, looked_at / 2);
}

TEST(Front, RangeIsThatOfTheMembersInIt) {
  const IntervalMath math = interval_math_builds().back();
  const Ticks begin = ticks_of(0.4), end = ticks_of(0.5);
  std::vector<Streak> streaks = {{0.0, 1.0, 0.0, 0.5, 1.0, 0.25f}, {0.45, 1.0, 0.0, 0.5, 1.0, 0.5f}};
  EXPECT_FLOAT_EQ(math.front_over(members_of(streaks).view(), begin, end).range, 0.25f);
  // One that comes later is not in it.
  streaks.push_back({0.6, 1.0, 0.0, 0.5, 1.0, 1.0f});
  EXPECT_FLOAT_EQ(math.front_over(members_of(streaks).view(), begin, end).range, 0.25f);
}

/// So that their light is where it is in time. The share is of the piece, and a straight line's.
TEST(Front, CentroidsOfMembersThatMoveFarAreNearTheTrueOnes) {
  const IntervalMath math = interval_math_builds().back();
  for (const double span : {0.4, 0.8, 1.2, 1.6})
    for (double middle = -1.7; middle <= 1.7; middle += 0.1) {
      const double rate = 4.0 * span;  // over a quarter of the exposure
      const MemberSet members = members_of({{0.0, 1.0, middle - 0.625 * rate, rate, 1.0}});
      const FrontSum front = math.front_over(members.view(), ticks_of(0.5), ticks_of(0.75));
      ASSERT_EQ(front.settled_until, ticks_of(0.75)) << span << " " << middle;
      const double centroid = double{front.swing.weight / front.mean.weight} / (6.0 / std::sqrt(3.0));
      const double far = std::max(0.0, span - 0.4);
      EXPECT_NEAR(centroid, gaussian_centroid(middle - 0.5 * span, middle + 0.5 * span),
                  1e-4 + 0.025 * far * far)
          << span << " " << middle;
    }
}

/// Members that move twice as far as sums can tell are together only where they are alike.
TEST(Front, UnlikeMembersMayNotMoveSoFar) {
  const IntervalMath math = interval_math_builds().back();
  const Ticks begin = ticks_of(0.5), end = ticks_of(0.75);
  std::vector<Streak> streaks = {{0.0, 1.0, -3.5, 5.0, 1.0, 0.5f}, {0.0, 1.0, -3.0, 5.0, 1.0, 0.5f}};
  EXPECT_EQ(math.front_over(members_of(streaks).view(), begin, end).settled_until, end);
  streaks[1].red = 0.9f;
  EXPECT_LT(math.front_over(members_of(streaks).view(), begin, end).settled_until, end);
}

}  // namespace
}  // namespace swept
