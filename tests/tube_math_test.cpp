// Rays by the block against intersect_tube() and intersect_bent_tube(), bit by bit, on every instruction set.
#include "abuffer/simd/tube_math.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "splat/kernel/bent_kernel.h"
#include "splat/kernel/ray_kernel.h"

namespace swept {
namespace {

using Random = std::mt19937;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

bool same(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

/// What nothing meant has, and what is on the brink.
double hard_value(Random& random) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr double values[] = {
      0.0,    -0.0,   1.0,   -1.0,  0.5,   -2.0,     1e-310,    1e-170,
      1e-150, -1e-20, 1e150, 1e170, 1e308, infinity, -infinity, std::numeric_limits<double>::quiet_NaN()};
  return values[random() % std::size(values)];
}

void put(TubeBlock& block, std::size_t i, const RayCoordinates<double>& ray) {
  block.u[i] = ray.u;
  block.v[i] = ray.v;
  block.z[i] = ray.z;
  block.du[i] = ray.du;
  block.dv[i] = ray.dv;
  block.dz[i] = ray.dz;
}

RayCoordinates<double> at(const TubeBlock& block, std::size_t i) {
  return {block.u[i], block.v[i], block.z[i], block.du[i], block.dv[i], block.dz[i]};
}

/// 1 if ray `i` met the kernel as it is expected to, with this fragment of a weight of 0.75; null: a miss.
std::size_t expect_the_bits(const TubeMath& math, const TubeBlock& block, const TubeHits& hits, std::size_t i,
                            double delta, const RayFragment<double>* expected) {
  const bool met = (hits.met >> i & 1) != 0;
  EXPECT_EQ(met, expected != nullptr) << math.name << ", ray " << i;
  if (!met || expected == nullptr) return 0;
  const double peak = 0.75 * std::exp(-delta * block.nearest_squared[i]);
  EXPECT_TRUE(same(block.t_begin[i], expected->t_begin) && same(block.t_end[i], expected->t_end) &&
              same(peak, expected->peak) && same(block.rate[i], expected->rate) &&
              same(block.y_begin[i], expected->y_begin) && same(block.z_begin[i], expected->z_begin) &&
              same(block.dz[i], expected->z_rate))
      << math.name << ", ray " << i;
  return 1;
}

/// How many of the first `count` met the kernel; and none, or another bit, is a failure.
std::size_t expect_the_tubes_bits(const TubeMath& math, TubeBlock& block, std::size_t count,
                                  const TubeSegment& segment) {
  const TubeHits hits = math.intersect(block, count, segment);
  EXPECT_EQ(hits.met & hits.odd, 0u);
  if (count < TubeBlock::most) {
    EXPECT_EQ((hits.met | hits.odd) >> count, 0u);
  }
  std::size_t met = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const RayCoordinates<double> ray = at(block, i);
    const double square = ray.du * ray.du + ray.dv * ray.dv;
    if ((hits.odd >> i & 1) != 0) {
      EXPECT_FALSE(square > 1e-290 && square < 1e300) << math.name << ": " << square << " is no odd square";
      continue;
    }
    RayFragment<double> f;
    const bool expected =
        intersect_tube<double>(ray, segment.begin, segment.end, segment.near, segment.delta, 0.75, f);
    met += expect_the_bits(math, block, hits, i, segment.delta, expected ? &f : nullptr);
  }
  return met;
}

TEST(TubeMath, GivesTheTubesBits) {
  const TubeMaths maths = tube_maths();
  for (std::size_t m = 0; m < maths.count; ++m) {
    Random random(1);
    TubeBlock block = {};
    std::size_t met = 0, looked_at = 0;
    for (int k = 0; k < 4000; ++k) {
      const std::size_t count = 1 + random() % TubeBlock::most;
      const double fast = std::exp2(uniform(random, -8.0, 8.0));
      const double begin = uniform(random, 0.0, 0.4);
      // As often as not the near plane is passed.
      const TubeSegment segment{begin, uniform(random, begin, 1.0), k % 2 == 0 ? 0.1 : 1.0, 3.0};
      for (std::size_t i = 0; i < count; ++i) {
        const bool still = random() % 8 == 0, level = random() % 4 == 0;
        put(block, i,
            {uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5), uniform(random, 0.5, 1.5),
             still ? 0.0 : fast * uniform(random, -1.0, 1.0), still ? 0.0 : fast * uniform(random, -1.0, 1.0),
             level ? 0.0 : uniform(random, -2.0, 2.0)});
      }
      met += expect_the_tubes_bits(maths.first[m], block, count, segment);
      looked_at += count;
    }
    EXPECT_GT(met, looked_at / 4) << "the test is to have something to look at";
    EXPECT_LT(met, looked_at - looked_at / 8);
  }
}

TEST(TubeMath, WhatIsHardlyANumberIsAMissOrLeftToTheTube) {
  const TubeMaths maths = tube_maths();
  for (std::size_t m = 0; m < maths.count; ++m) {
    Random random(2);
    TubeBlock block = {};
    for (int k = 0; k < 4000; ++k) {
      for (std::size_t i = 0; i < TubeBlock::most; ++i) {
        double value[6];
        for (double& x : value) x = random() % 3 == 0 ? hard_value(random) : uniform(random, -1.0, 1.0);
        put(block, i, {value[0], value[1], value[2], value[3], value[4], value[5]});
      }
      (void)expect_the_tubes_bits(maths.first[m], block, TubeBlock::most, {0.0, 1.0, 1e-3, 3.0});
    }
  }
}

/// How many of the rays met the bent kernel; and none, or another bit, is a failure.
std::size_t expect_the_bent_tubes_bits(const TubeMath& math, TubeBlock& block, const TubeBends& bends,
                                       std::size_t count, const TubeSegment& segment, std::size_t& odd) {
  const TubeBlock given = block;
  const TubeHits hits = math.intersect_bent(block, bends, count, segment);
  EXPECT_EQ(hits.met & hits.odd, 0u);
  odd += static_cast<std::size_t>(std::popcount(hits.odd));
  std::size_t met = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if ((hits.odd >> i & 1) != 0) continue;
    RayFragment<double> f;
    const bool expected =
        intersect_bent_tube<double>(at(given, i), {bends.u[i], bends.v[i], bends.z[i]}, segment.begin,
                                    segment.end, segment.near, segment.delta, 0.75, f);
    met += expect_the_bits(math, block, hits, i, segment.delta, expected ? &f : nullptr);
  }
  return met;
}

TEST(TubeMath, GivesTheBentTubesBits) {
  const TubeMaths maths = tube_maths();
  for (std::size_t m = 0; m < maths.count; ++m) {
    Random random(3);
    TubeBlock block = {};
    TubeBends bends = {};
    std::size_t met = 0, looked_at = 0, odd = 0;
    for (int k = 0; k < 4000; ++k) {
      const std::size_t count = 1 + random() % TubeBlock::most;
      const double fast = std::exp2(uniform(random, -8.0, 8.0)), bent = std::exp2(uniform(random, -8.0, 4.0));
      const double begin = uniform(random, 0.0, 0.4);
      const TubeSegment segment{begin, uniform(random, begin, 1.0), k % 2 == 0 ? 0.1 : 1.0, 3.0};
      for (std::size_t i = 0; i < count; ++i) {
        // Some stand still but for their bend, and some have none.
        const bool still = random() % 8 == 0, straight = random() % 8 == 0;
        put(block, i,
            {uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5), uniform(random, 0.5, 1.5),
             still ? 0.0 : fast * uniform(random, -1.0, 1.0), still ? 0.0 : fast * uniform(random, -1.0, 1.0),
             random() % 4 == 0 ? 0.0 : uniform(random, -2.0, 2.0)});
        for (double* const bend : {bends.u, bends.v, bends.z})
          bend[i] = straight ? 0.0 : bent * uniform(random, -1.0, 1.0);
      }
      met += expect_the_bent_tubes_bits(maths.first[m], block, bends, count, segment, odd);
      looked_at += count;
    }
    EXPECT_GT(met, looked_at / 4) << "the test is to have something to look at";
    EXPECT_LT(met, looked_at - looked_at / 8);
    EXPECT_LT(odd, looked_at / 1000) << "or the scalar path would be the one that runs";
  }
}

TEST(TubeMath, WhatIsHardlyABentPathIsAMissOrLeftToTheTube) {
  const TubeMaths maths = tube_maths();
  for (std::size_t m = 0; m < maths.count; ++m) {
    Random random(4);
    TubeBlock block = {};
    TubeBends bends = {};
    std::size_t met = 0, odd = 0;
    for (int k = 0; k < 4000; ++k) {
      for (std::size_t i = 0; i < TubeBlock::most; ++i) {
        double value[9];
        for (double& x : value) x = random() % 4 == 0 ? hard_value(random) : uniform(random, -1.0, 1.0);
        put(block, i, {value[0], value[1], value[2], value[3], value[4], value[5]});
        bends.u[i] = value[6], bends.v[i] = value[7], bends.z[i] = value[8];
      }
      met += expect_the_bent_tubes_bits(maths.first[m], block, bends, TubeBlock::most, {0.0, 1.0, 1e-3, 3.0},
                                        odd);
    }
    EXPECT_GT(met, 10000u);
    EXPECT_GT(odd, 10000u);
  }
}

/// Or the scalar path would be the one that runs.
TEST(TubeMath, OrdinaryRaysAreNotOdd) {
  const TubeMaths maths = tube_maths();
  ASSERT_GE(maths.count, 1u);
  TubeBlock block = {};
  for (std::size_t i = 0; i < TubeBlock::most; ++i)
    put(block, i, {0.0, 0.0, 1.0, std::exp2(static_cast<double>(i) - 32.0), 0.0, 0.0});
  for (std::size_t m = 0; m < maths.count; ++m) {
    const TubeHits hits = maths.first[m].intersect(block, TubeBlock::most, {0.0, 1.0, 0.1, 3.0});
    EXPECT_EQ(hits.odd, 0u) << maths.first[m].name;
    EXPECT_EQ(hits.met, ~std::uint64_t{0}) << maths.first[m].name;
  }
}

}  // namespace
}  // namespace swept
