// The sweep's arithmetic, built for every instruction set: its means against a 50-digit oracle, and the same
// bits from all builds.
#include "abuffer/simd/interval_math.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/resolve/members.h"
#include "splat/kernel/kernel_integral.h"
#include "tests/oracle/oracle.h"

namespace swept {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

struct Fragment {
  Ticks t_begin = 0;
  float y = 0.0f, rate = 0.0f, peak = 1.0f, z = 1.0f, z_rate = 0.0f;
};

void push(MemberSet& members, FragmentArrays& arrays, const Fragment& f, const Shade& shade) {
  arrays.ensure(1);
  arrays.t_begin[0] = f.t_begin;
  arrays.t_end[0] = shutter_close;
  arrays.y[0] = f.y;
  arrays.rate[0] = f.rate;
  arrays.peak[0] = f.peak;
  arrays.z[0] = f.z;
  arrays.z_rate[0] = f.z_rate;
  members.push(arrays, 0, shade);
}

float mean_of(const IntervalMath& math, const Fragment& fragment, Ticks begin, Ticks end) {
  MemberSet members;
  FragmentArrays arrays;
  push(members, arrays, fragment, {});
  float mean[member_lanes];
  (void)math.sum_over(members.view(), begin, end, mean);
  return mean[0];
}

/// A struct of floats alone; as bits even zeros of either sign differ.
template <class Floats>
auto bits_of_floats(const Floats& floats) {
  static_assert(sizeof(Floats) % sizeof(float) == 0);
  return std::bit_cast<std::array<std::uint32_t, sizeof(Floats) / sizeof(float)>>(floats);
}

/// On a grid of 2⁻¹⁶ up to 8, for ends, middle and span to be exact in float.
float on_grid(double y) { return static_cast<float>(std::round(y * 65536.0) / 65536.0); }

/// Of all cases; `plain` is called with the two ends.
template <class Mean>
double worst_ulps(const Mean& mean, int points) {
  Random random(1);
  double worst = 0.0;
  for (int i = 0; i < points; ++i) {
    const float a = on_grid(uniform(random, -7.0, 7.0));
    const float span = on_grid(random() % 4 ? uniform(random, 0.0, 0.5) : uniform(random, 0.0, 7.0 - a));
    const double off =
        oracle::ulps(mean(a, span), oracle::mean_gaussian(a, double{a} + span, oracle::Digits::quad));
    worst = off <= worst ? worst : off;
  }
  return worst;
}

TEST(IntervalMath, MeanIsWithin5UlpInEveryBuild) {
  ASSERT_GE(interval_math_builds().size(), 2u);
  for (const IntervalMath& math : interval_math_builds())
    EXPECT_LE(worst_ulps([&](float a,
                             float span) { return mean_of(math, {.y = a, .rate = span}, 0, shutter_close); },
                         40000),
              5.0)
        << math.name;
}

/// What it replaced: y² rounded before exp.
TEST(IntervalMath, TheCheckCatchesAPlainSquare) {
  const auto plain = [](float a, float span) {
    const float middle = a + 0.5f * span;
    return span <= 0.5f && span * std::abs(middle) <= 1.0f
               ? std::exp(-middle * middle) * GaussianSeries<float>::factor(middle, span)
               : mean_gaussian(a, a + span);
  };
  EXPECT_GT(worst_ulps(plain, 40000), 20.0);
}

/// Fragments of any kind, and as brief as 2⁻²⁴ of the exposure wherever in it. What is rounded: the middle's
/// distance from t_begin, by 2ε of it, and its product with the rate; the sum, by ε|middle|; the span, by 2ε
/// of itself. The mean's logarithm changes by at most 2|y| per change of y, y being the farther end.
TEST(IntervalMath, MeanMovesWithItsEndsRoundingAndNoMore) {
  Random random(2);
  for (const IntervalMath& math : interval_math_builds()) {
    double worst = 0.0;
    for (int i = 0; i < 40000; ++i) {
      const double begin_y = uniform(random, -7.0, 3.0), end_y = uniform(random, begin_y, 7.0);
      const Ticks duration = ticks_of(std::exp2(uniform(random, -24.0, 0.0)));
      const auto between = [&](Ticks low, Ticks high) {
        return std::uniform_int_distribution<Ticks>(low, high)(random);
      };
      const Ticks t_begin = between(0, shutter_close - duration), t_end = t_begin + duration;
      const Fragment f{.t_begin = t_begin,
                       .y = static_cast<float>(begin_y),
                       .rate = static_cast<float>((end_y - begin_y) / share_of(duration))};
      const Ticks begin = between(t_begin, t_end), end = between(begin, t_end);
      const auto at = [&](Ticks t) { return double{f.y} + double{f.rate} * share_of(t - f.t_begin); };
      const oracle::Exact exact = oracle::mean_gaussian(at(begin), at(end), oracle::Digits::quad);
      const double farther = std::max(std::abs(at(begin)), std::abs(at(end)));
      const double moved = 0x1p-24 * (3 * (at(end) - double{f.y}) + farther + 2 * (at(end) - at(begin)));
      const double bound =
          5.0 * oracle::ulp<float>(exact.high) + exact.high * std::expm1(2 * (farther + moved) * moved);
      worst = std::max(worst, oracle::error(mean_of(math, f, begin, end), exact) / bound);
    }
    EXPECT_LE(worst, 1.0) << math.name;
    EXPECT_GT(worst, 0.2) << math.name << ": the bound says nothing";
  }
}

bool same_bits(const float* a, const float* b, std::size_t count) {
  return std::memcmp(a, b, count * sizeof(float)) == 0;
}

TEST(IntervalMath, AllBuildsGiveTheSameBits) {
  Random random(3);
  const auto builds = interval_math_builds();
  for (int i = 0; i < 20000; ++i) {
    MemberSet members;
    FragmentArrays arrays;
    const int count = 1 + static_cast<int>(random() % 40);
    const double fastest = random() % 3 ? 0.5 : 8.0;
    for (int k = 0; k < count; ++k) {
      Shade shade{};
      for (float& channel : shade.rgba) channel = static_cast<float>(uniform(random, 0.0, 1.0));
      shade.depth_tolerance = static_cast<float>(uniform(random, 0.0, 0.1));
      push(members, arrays,
           {ticks_of(uniform(random, 0.0, 0.2)), static_cast<float>(uniform(random, -7.0, 7.0)),
            static_cast<float>(uniform(random, 0.0, fastest)), static_cast<float>(uniform(random, 0.0, 1.0)),
            static_cast<float>(uniform(random, 1.0, 9.0)), static_cast<float>(uniform(random, -1.0, 1.0))},
           shade);
    }
    const Members view = members.view();
    const double from = uniform(random, 0.2, 0.9);
    const Ticks begin = ticks_of(from), end = random() % 4 ? ticks_of(uniform(random, from, 1.0)) : begin;
    std::vector<float> first[3], mine[3];
    for (int a = 0; a < 3; ++a) {
      first[a].resize(view.padded);
      mine[a].resize(view.padded);
    }
    const MemberSum sum = builds[0].sum_over(view, begin, end, first[0].data());
    const DepthRange range = builds[0].depths_over(view, begin, end, first[1].data(), first[2].data());
    for (const IntervalMath& math : builds.subspan(1)) {
      const MemberSum other = math.sum_over(view, begin, end, mine[0].data());
      const DepthRange other_range = math.depths_over(view, begin, end, mine[1].data(), mine[2].data());
      ASSERT_EQ(bits_of_floats(sum), bits_of_floats(other)) << math.name << " " << i;
      ASSERT_EQ(bits_of_floats(range), bits_of_floats(other_range)) << math.name << " " << i;
      for (int a = 0; a < 3; ++a)
        ASSERT_TRUE(same_bits(first[a].data(), mine[a].data(), view.count)) << math.name << " " << i;
    }
  }
}

/// Fragments that begin and end anywhere, at depths of one surface or of several.
TEST(IntervalMath, FrontsAndSwingsHaveTheSameBitsInAllBuilds) {
  Random random(4);
  const auto builds = interval_math_builds();
  int whole = 0, cut = 0;
  for (int i = 0; i < 20000; ++i) {
    MemberSet members;
    FragmentArrays arrays;
    arrays.ensure(1);
    const int count = 1 + static_cast<int>(random() % 40);
    const double spread = random() % 2 ? 0.02 : 0.3;
    for (int k = 0; k < count; ++k) {
      const double from = uniform(random, 0.0, 0.6), to = uniform(random, from + 0.01, 1.0);
      arrays.t_begin[0] = ticks_of(from);
      arrays.t_end[0] = ticks_of(to);
      arrays.y[0] = static_cast<float>(uniform(random, -2.0, 1.0));
      arrays.rate[0] = static_cast<float>(uniform(random, 0.0, 4.0));
      arrays.peak[0] = static_cast<float>(uniform(random, 0.0, 1.0));
      arrays.z[0] = static_cast<float>(3.0 + uniform(random, 0.0, spread));
      arrays.z_rate[0] = static_cast<float>(uniform(random, -0.01, 0.01));
      members.push(arrays, 0, {{0.5f, 0.25f, static_cast<float>(uniform(random, 0.0, 1.0)), 1.0f}, 0.05f});
    }
    const Members view = members.view();
    const Ticks begin = ticks_of(uniform(random, 0.1, 0.6)),
                end = begin + ticks_of(uniform(random, 1e-3, 0.2));
    const FrontSum front = builds[0].front_over(view, begin, end);
    ++(front.settled_until == end ? whole : cut);
    std::vector<float> mean(view.padded), from(view.padded), to(view.padded);
    (void)builds[0].sum_over(view, begin, end, mean.data());
    (void)builds[0].depths_over(view, begin, end, from.data(), to.data());
    std::array<std::vector<float>, 4> first, mine;
    const auto swings = [&](const IntervalMath& math, std::array<std::vector<float>, 4>& out) {
      for (std::vector<float>& field : out) field.resize(view.padded);
      math.swings_over(view, begin, end, mean.data(),
                       {from.data(), to.data(), out[0].data(), out[1].data(), out[2].data(), out[3].data()});
    };
    swings(builds[0], first);
    std::array<std::vector<float>, 8> first_presences, presences;
    const auto present = [&](const IntervalMath& math, std::array<std::vector<float>, 8>& out) {
      for (std::vector<float>& field : out) field.resize(view.padded);
      return math.presences_over(view, begin, end,
                                 {out[0].data(), out[1].data(), out[2].data(), out[3].data(), out[4].data(),
                                  out[5].data(), out[6].data(), out[7].data()});
    };
    const PresenceRange range = present(builds[0], first_presences);
    for (const IntervalMath& math : builds.subspan(1)) {
      ASSERT_EQ(bits_of_floats(range), bits_of_floats(present(math, presences))) << math.name << " " << i;
      for (int a = 0; a < 8; ++a)
        ASSERT_TRUE(same_bits(first_presences[a].data(), presences[a].data(), view.count))
            << math.name << " " << i;
      const FrontSum other = math.front_over(view, begin, end);
      ASSERT_EQ(front.settled_until, other.settled_until) << math.name << " " << i;
      if (front.settled_until == end) {
        ASSERT_EQ(bits_of_floats(front.mean), bits_of_floats(other.mean)) << math.name << " " << i;
        ASSERT_EQ(bits_of_floats(front.swing), bits_of_floats(other.swing)) << math.name << " " << i;
        ASSERT_EQ(front.low, other.low) << math.name << " " << i;
      }
      swings(math, mine);
      for (int a = 0; a < 4; ++a)
        ASSERT_TRUE(same_bits(first[a].data(), mine[a].data(), view.count)) << math.name << " " << i;
    }
  }
  EXPECT_GT(whole, 1000);
  EXPECT_GT(cut, 100);
}

/// A fragment that passes the pixel within a tick: its y there may be anything up to rate · 2⁻³¹, where exp's
/// exponent once wrapped around.
TEST(IntervalMath, YFarOutOfRangeIsNothingSeen) {
  for (const IntervalMath& math : interval_math_builds())
    for (const float y : {9.0f, 9.31f, 13.0f, 20.0f, 22.0f, 1e3f, 1e15f, 1e30f})
      for (const float sign : {-1.0f, 1.0f}) {
        const float mean = mean_of(math, {.y = sign * y}, shutter_close / 2, shutter_close / 2);
        EXPECT_TRUE(mean >= 0.0f && mean <= std::exp(-80.0f)) << math.name << " " << y << " " << mean;
      }
}

TEST(IntervalMath, AtItsPeakAFragmentIsItsPeak) {
  for (const IntervalMath& math : interval_math_builds())
    for (const float peak : {1.0f, 0.3f, 0x1p-126f})
      EXPECT_EQ(mean_of(math, {.peak = peak}, shutter_close / 4, shutter_close / 4 * 3), peak);
}

}  // namespace
}  // namespace swept
