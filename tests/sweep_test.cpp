// The sweep on planted fragments, against integrals that are known.
#include "abuffer/resolve/sweep.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "abuffer/resolve/still.h"

namespace swept {
namespace {

/// A handful of float roundings on values of at most 1: sums of few terms, exp and erf good to 4 ulp, planted
/// times in float.
constexpr double few_roundings = 16 * 0x1p-24;

struct Planted {
  FragmentArrays fragments;
  std::vector<Shade> shades;
  SweepCounters counters;

  struct Fragment {
    float t_begin = 0.0f, t_end = 1.0f, y = 0.0f, rate = 0.0f, peak = 1.0f, z = 1.0f, z_rate = 0.0f;
  };
  void add(const Fragment& f, const Shade& shade) {
    fragments.ensure(1);
    const std::size_t i = fragments.count++;
    fragments.pixel[i] = 0;
    fragments.kernel[i] = static_cast<std::uint32_t>(shades.size());
    fragments.t_begin[i] = ticks_of(f.t_begin);
    fragments.t_end[i] = ticks_of(f.t_end);
    fragments.y[i] = f.y;
    fragments.rate[i] = f.rate;
    fragments.peak[i] = f.peak;
    fragments.z[i] = f.z;
    fragments.z_rate[i] = f.z_rate;
    shades.push_back(shade);
  }
  PixelSum sweep(Coverage coverage = Coverage::soft, double edge_weight = 0.5,
                 Normalisation normalisation = Normalisation::interval) {
    ImageModel model;
    model.coverage = coverage;
    model.edge_weight = edge_weight;
    std::vector<std::uint32_t> indices(fragments.count);
    std::iota(indices.begin(), indices.end(), 0u);
    PixelSum pixel;
    PixelSweep(SurfaceModel(model, normalisation))
        .resolve(fragments, shades, indices.data(), indices.size(), pixel, counters);
    return pixel;
  }
};

constexpr Shade red{{1.0f, 0.0f, 0.0f, 1.0f}, 0.1f};
constexpr Shade green{{0.0f, 1.0f, 0.0f, 1.0f}, 0.1f};
constexpr Shade half_blue{{0.0f, 0.0f, 0.5f, 0.5f}, 0.1f};

TEST(Sweep, LoneFragmentCoversItsShareOfTheExposure) {
  Planted p;
  p.add({.t_begin = 0.25f, .t_end = 0.625f}, red);
  const PixelSum pixel = p.sweep(Coverage::hard);
  EXPECT_DOUBLE_EQ(pixel.rgba[0], 0.375);
  EXPECT_DOUBLE_EQ(pixel.rgba[3], 0.375);
  EXPECT_EQ(p.counters.intervals, 1u);
}

TEST(Sweep, ThinStreakHasTheClosedFormOfItsErf) {
  // Below the edge weight soft coverage is linear: alpha = ∫ρ / edge.
  Planted p;
  p.add({.t_begin = 0.2f, .t_end = 0.7f, .y = -1.5f, .rate = 6.0f, .peak = 0.1f}, red);
  const double integral = 0.1 * 0.5 * std::sqrt(std::numbers::pi) * 2.0 * std::erf(1.5) / 6.0;
  EXPECT_NEAR(p.sweep().rgba[3], integral / 0.5, few_roundings);
  EXPECT_EQ(p.counters.intervals, 1u);
}

TEST(Sweep, DepthOfAThinStreakIsThatOfItsWeight) {
  // ρ is greatest as it begins, where it is nearest: ∫ρ(1 + 2τ)/∫ρ, with ∫τρ = (1 − e^(−r²))/2r².
  Planted p;
  p.add({.y = 0.0f, .rate = 1.5f, .peak = 0.1f, .z = 1.0f, .z_rate = 2.0f}, red);
  const double integral = 0.5 * std::sqrt(std::numbers::pi) * std::erf(1.5) / 1.5;
  const double moment = (1.0 - std::exp(-2.25)) / (2.0 * 2.25);
  const PixelSum pixel = p.sweep();
  // The centroid's 7e-5 of the two units it moves by.
  EXPECT_NEAR(pixel.depth / pixel.rgba[3], 1.0 + 2.0 * moment / integral, 2.0 * 7e-5);
  // What covers all the pixel is seen as long wherever it is.
  Planted all;
  all.add({.y = 0.0f, .rate = 0.5f, .z = 1.0f, .z_rate = 2.0f}, red);
  const PixelSum covered = all.sweep();
  EXPECT_NEAR(covered.depth / covered.rgba[3], 2.0, few_roundings);
}

TEST(Sweep, CoverageIsClampedWithinAPiece) {
  // ρ = exp(−y²), y from −1.5 to 1.5; min(1, 2ρ) is 1 for |y| ≤ √ln 2.
  Planted p;
  p.add({.t_begin = 0.0f, .t_end = 1.0f, .y = -1.5f, .rate = 3.0f}, red);
  const double edge = std::sqrt(std::numbers::ln2);
  const double exact =
      (2.0 * edge + 2.0 * std::sqrt(std::numbers::pi) * (std::erf(1.5) - std::erf(edge))) / 3.0;
  // Pieces may err by coverage_error (2⁻¹⁵) each at the two places where the clamp sets in.
  EXPECT_NEAR(p.sweep().rgba[3], exact, 2 * 0x1p-15);
}

TEST(Sweep, CoverageOfAnyLoneStreakIsItsIntegral) {
  std::mt19937 random(11);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 8) * 0x1p-24;
  };
  for (int i = 0; i < 2000; ++i) {
    const double y = uniform(-1.7, 1.0), end = uniform(y, 1.7), begin_time = uniform(0.0, 0.5);
    const double end_time = uniform(begin_time + 1e-3, 1.0), peak = uniform(0.2, 1.0);
    Planted p;
    const Planted::Fragment f{.t_begin = static_cast<float>(begin_time),
                              .t_end = static_cast<float>(end_time),
                              .y = static_cast<float>(y),
                              .rate = static_cast<float>((end - y) / (end_time - begin_time)),
                              .peak = static_cast<float>(peak)};
    p.add(f, red);
    const int steps = 4000;
    double exact = 0.0;
    for (int k = 0; k < steps; ++k) {
      const double along = f.y + f.rate * (f.t_end - f.t_begin) * (k + 0.5) / steps;
      exact += std::min(1.0, 2.0 * f.peak * std::exp(-along * along)) / steps;
    }
    // coverage_error (2⁻¹⁵) at the two places where the clamp may set in; the sum's own error is below 1e-6.
    ASSERT_NEAR(p.sweep().rgba[3], exact * (f.t_end - f.t_begin), 2 * 0x1p-15 + 1e-6)
        << "y " << f.y << " rate " << f.rate << " peak " << f.peak << " t " << f.t_begin << " " << f.t_end;
  }
}

TEST(Sweep, NormalisationIsPerInstantAndNotPerPixel) {
  // Two kernels share a surface in the first half; one is alone in the second. Per pixel the weights would
  // mix the halves: ∫ρw / ∫ρ = (1/3, 2/3).
  Planted p;
  p.add({.t_begin = 0.0f, .t_end = 0.5f}, red);
  p.add({.t_begin = 0.0f, .t_end = 1.0f}, green);
  const PixelSum pixel = p.sweep();
  EXPECT_DOUBLE_EQ(pixel.rgba[0], 0.25);
  EXPECT_DOUBLE_EQ(pixel.rgba[1], 0.75);
  Planted heavier;
  heavier.add({.t_begin = 0.0f, .t_end = 0.5f, .peak = 0.6f}, red);
  heavier.add({.t_begin = 0.0f, .t_end = 1.0f, .peak = 0.6f}, green);
  EXPECT_NEAR(heavier.sweep().rgba[0], 0.25, few_roundings);
}

TEST(Sweep, NormalisationPerPixelDividesByTheWholeExposure) {
  // Green is hidden until the red streak in front of it ends. Both cover all of the pixel, so per interval
  // each has half of the exposure; per pixel, its share of the visible ∫ρ: √π erf(0.8)/3.2 of red, 0.6 · ½ of
  // green.
  const auto planted = [] {
    Planted p;
    p.add({.t_begin = 0.0f, .t_end = 0.5f, .y = -0.8f, .rate = 3.2f, .z = 1.0f}, red);
    p.add({.t_begin = 0.125f, .t_end = 1.0f, .peak = 0.6f, .z = 5.0f}, green);
    return p;
  };
  const PixelSum interval = planted().sweep();
  EXPECT_NEAR(interval.rgba[0], 0.5, few_roundings);
  EXPECT_NEAR(interval.rgba[1], 0.5, few_roundings);
  const PixelSum pixel = planted().sweep(Coverage::soft, 0.5, Normalisation::pixel);
  const double seen_red = std::sqrt(std::numbers::pi) * std::erf(0.8) / 3.2, seen_green = 0.3;
  EXPECT_NEAR(pixel.rgba[0], seen_red / (seen_red + seen_green), few_roundings);
  EXPECT_NEAR(pixel.rgba[1], seen_green / (seen_red + seen_green), few_roundings);
  EXPECT_EQ(pixel.rgba[3], interval.rgba[3]);
  EXPECT_EQ(pixel.depth, interval.depth);
  // The exposure's alpha is kept: of what covers a third of the time, a third.
  Planted brief;
  brief.add({.t_end = 0.25f}, red);
  brief.add({.t_begin = 0.125f, .t_end = 0.375f}, green);
  const PixelSum third = brief.sweep(Coverage::hard, 0.5, Normalisation::pixel);
  EXPECT_NEAR(third.rgba[0], 0.375 / 2, few_roundings);
  EXPECT_NEAR(third.rgba[1], 0.375 / 2, few_roundings);
  EXPECT_DOUBLE_EQ(third.rgba[3], 0.375);
  // Opacity is a kernel's own: with equal ρ a half transparent front lets half of the light through.
  Planted veil;
  veil.add({.t_end = 0.5f, .z = 2.0f}, half_blue);
  veil.add({.z = 3.0f}, green);
  const PixelSum veiled = veil.sweep(Coverage::soft, 0.5, Normalisation::pixel);
  EXPECT_NEAR(veiled.rgba[1], 0.75, few_roundings);
  EXPECT_NEAR(veiled.rgba[2], 0.25, few_roundings);
}

TEST(Sweep, CrossingSurfacesSwapWhereTheirDepthsDo) {
  // z = 2 against z = 1 + 3t: green comes forward at t = 1/3, but within the tolerance 0.1 of each other they
  // are one surface of equal weights.
  Planted p;
  p.add({.z = 2.0f}, green);
  p.add({.z = 1.0f, .z_rate = 3.0f}, red);
  const PixelSum pixel = p.sweep();
  const double mixed = 2.0 * 0.1 / 3.0;
  EXPECT_NEAR(pixel.rgba[0], (1.0 - 0.1) / 3.0 + 0.5 * mixed, few_roundings);
  EXPECT_NEAR(pixel.rgba[1], 1.0 - (1.0 + 0.1) / 3.0 + 0.5 * mixed, few_roundings);
  EXPECT_NEAR(pixel.rgba[3], 1.0, few_roundings);
  EXPECT_GE(p.counters.crossings, 2u);
}

TEST(Sweep, SurfacesCompositeFrontToBack) {
  Planted p;
  p.add({.z = 3.0f}, green);
  p.add({.t_begin = 0.5f, .z = 2.0f}, half_blue);
  const PixelSum pixel = p.sweep();
  EXPECT_NEAR(pixel.rgba[1], 0.75, few_roundings);
  EXPECT_NEAR(pixel.rgba[2], 0.25, few_roundings);
  EXPECT_NEAR(pixel.rgba[3], 1.0, few_roundings);
  EXPECT_NEAR(pixel.depth, 3.0 * 0.75 + 2.0 * 0.25, 3.0 * few_roundings);
}

TEST(Sweep, LightBetweenTwoThinSurfacesIsCorrelatedInTime) {
  // Both cover α = 2ρ, and both at the same time: the back one gets ∫2ρ(1 − 2ρ), not the product of the
  // means.
  Planted p;
  const double peak = 0.4;
  p.add({.y = -1.5f, .rate = 3.0f, .peak = 0.4f, .z = 1.0f}, red);
  p.add({.y = -1.5f, .rate = 3.0f, .peak = 0.4f, .z = 2.0f}, green);
  const double root_pi = std::sqrt(std::numbers::pi);
  const double mean = peak * root_pi * std::erf(1.5) / 3.0;
  const double mean_square =
      peak * peak * root_pi / std::numbers::sqrt2 * std::erf(1.5 * std::numbers::sqrt2) / 3.0;
  const PixelSum pixel = p.sweep();
  // Two-point Gauss on pieces of span s ≤ 1/2: relative (s⁴/4320)·max|f⁗| with f = ρ²-like, |f⁗| ≤ 48: 7e-4
  // worst, and its sign alternates along the bell. Half of that is asked for.
  EXPECT_NEAR(pixel.rgba[0], 2.0 * mean, 3.5e-4 * 2.0 * mean);
  EXPECT_NEAR(pixel.rgba[1], 2.0 * mean - 4.0 * mean_square, 3.5e-4 * 2.0 * mean);
  EXPECT_GT(std::abs(2.0 * mean * (1.0 - 2.0 * mean) - pixel.rgba[1]), 0.05) << "the case does not tell";
}

TEST(Sweep, WhatIsHiddenComesBackWhenTheFrontLeaves) {
  // A front of many short fragments covers [0, ½] without a gap; the back was there all along, and its own
  // pieces begin and end while hidden.
  Planted p;
  for (int i = 0; i < 32; ++i)
    p.add({.t_begin = static_cast<float>(i) / 64.0f, .t_end = static_cast<float>(i + 1) / 64.0f, .z = 1.0f},
          red);
  for (int i = 0; i < 16; ++i)
    p.add({.t_begin = static_cast<float>(i) / 16.0f, .t_end = static_cast<float>(i + 1) / 16.0f, .z = 5.0f},
          green);
  const PixelSum pixel = p.sweep();
  EXPECT_DOUBLE_EQ(pixel.rgba[0], 0.5);
  EXPECT_DOUBLE_EQ(pixel.rgba[1], 0.5);
  EXPECT_GT(p.counters.hidden, 0u);
  EXPECT_GT(p.counters.revealed, 0u);
}

TEST(Sweep, StillFragmentsGiveTheStillPixel) {
  std::mt19937 random(7);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  Planted p;
  for (int i = 0; i < 40; ++i)
    p.add({.peak = 0.3f * uniform(), .z = 1.0f + 4.0f * uniform()},
          {{0.5f * uniform(), 0.5f * uniform(), 0.5f * uniform(), 0.5f}, 0.2f});
  std::vector<std::uint32_t> indices(p.fragments.count);
  std::iota(indices.begin(), indices.end(), 0u);
  PixelSum still;
  StillPixel(SurfaceModel(ImageModel{}))
      .resolve(p.fragments, p.shades, indices.data(), indices.size(), still);
  const PixelSum swept = p.sweep();
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(swept.rgba[c], still.rgba[c], few_roundings) << c;
}

TEST(Sweep, TenThousandFragmentsInOnePixel) {
  // Equal weights, so the colour is the mean over time of the share of red among the active.
  Planted p;
  std::mt19937 random(3);
  std::vector<std::pair<float, float>> reds, greens;
  for (int i = 0; i < 10000; ++i) {
    const float begin = static_cast<float>(random() % 1000) / 1024.0f, end = begin + 24.0f / 1024.0f;
    const bool is_red = random() % 3 == 0;
    p.add({.t_begin = begin, .t_end = end}, is_red ? red : green);
    (is_red ? reds : greens).emplace_back(begin, end);
  }
  double exact = 0.0, covered = 0.0;
  for (int step = 0; step < 1024; ++step) {
    const float t = (static_cast<float>(step) + 0.5f) / 1024.0f;
    const auto active = [&](const auto& list) {
      return static_cast<double>(std::count_if(list.begin(), list.end(),
                                               [&](const auto& f) { return f.first < t && t < f.second; }));
    };
    const double r = active(reds), g = active(greens);
    if (r + g > 0.0) {
      exact += r / (r + g) / 1024.0;
      covered += 1.0 / 1024.0;
    }
  }
  const PixelSum pixel = p.sweep();
  // Sums of up to 300 floats, in eight lanes.
  EXPECT_NEAR(pixel.rgba[0], exact, 40 * 0x1p-24);
  EXPECT_NEAR(pixel.rgba[3], covered, 40 * 0x1p-24);
}

TEST(Sweep, CoincidentCrossingsDoNotStall) {
  // Many surfaces meet in one point of (time, depth), none within another's tolerance elsewhere.
  Planted p;
  for (int i = 0; i < 64; ++i) {
    const float rate = static_cast<float>(i - 32);
    p.add({.z = 40.0f - 0.5f * rate, .z_rate = rate}, {{1.0f, 0.0f, 0.0f, 1.0f}, 1e-6f});
  }
  EXPECT_NEAR(p.sweep().rgba[3], 1.0, 64 * 0x1p-24);
  EXPECT_LT(p.counters.intervals, 64u * 64u);
}

TEST(Sweep, LayersThatNeverMergeSwapWhereTheyCross) {
  // Tolerance 0 and still weights: between crossings the picture stands, so it is a sum over them.
  std::mt19937 random(5);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  for (int round = 0; round < 20; ++round) {
    Planted p;
    const int count = 2 + static_cast<int>(random() % 30);
    for (int i = 0; i < count; ++i) {
      const float opacity = 0.3f * uniform();
      p.add({.z = 10.0f + uniform(), .z_rate = 4.0f * (uniform() - 0.5f)},
            {{opacity * uniform(), opacity * uniform(), opacity * uniform(), opacity}, 0.0f});
    }
    const FragmentArrays& f = p.fragments;
    std::vector<double> times = {0.0, 1.0};
    for (int i = 0; i < count; ++i)
      for (int k = 0; k < i; ++k) {
        const double t = (double{f.z[k]} - f.z[i]) / (double{f.z_rate[i]} - f.z_rate[k]);
        if (t > 0.0 && t < 1.0) times.push_back(t);
      }
    std::sort(times.begin(), times.end());
    double exact[4] = {0.0, 0.0, 0.0, 0.0};
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
      const double middle = 0.5 * (times[i] + times[i + 1]);
      std::vector<int> order(static_cast<std::size_t>(count));
      std::iota(order.begin(), order.end(), 0);
      std::sort(order.begin(), order.end(),
                [&](int a, int b) { return f.z[a] + f.z_rate[a] * middle < f.z[b] + f.z_rate[b] * middle; });
      double left = times[i + 1] - times[i];
      for (const int k : order) {
        const Shade& shade = p.shades[static_cast<std::size_t>(k)];
        for (int c = 0; c < 4; ++c) exact[c] += left * shade.rgba[c];
        left *= 1.0 - shade.rgba[3];
      }
    }
    const PixelSum pixel = p.sweep();
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(pixel.rgba[c], exact[c], few_roundings) << round << " " << c;
    // Not a piece for each crossing.
    EXPECT_EQ(p.counters.intervals, 1u);
  }
}

/// A thousand brief streaks of one depth, forty at a time, of colours within `range`. Checks the colour
/// against that of each event by event, and returns how many pieces it took.
std::uint64_t pieces_of_a_dense_front(float range, double tolerance) {
  std::mt19937 random(9);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  Planted p;
  for (int i = 0; i < 1000; ++i) {
    const float begin = 0.96f * uniform();
    const auto color = [&] { return 0.5f * (1.0f - range) + range * uniform(); };
    p.add({.t_begin = begin, .t_end = begin + 0.04f, .y = -1.7f, .rate = 85.0f},
          {{color(), color(), color(), 1.0f}, 0.1f});
  }
  const PixelSum pixel = p.sweep();
  EXPECT_GT(p.counters.merged, 0u);
  const FragmentArrays& f = p.fragments;
  double exact[3] = {0.0, 0.0, 0.0};
  const int steps = 40000;
  for (int step = 0; step < steps; ++step) {
    const double t = (step + 0.5) / steps;
    double weight = 0.0, sum[3] = {0.0, 0.0, 0.0};
    for (std::size_t i = 0; i < f.count; ++i) {
      if (t < share_of(f.t_begin[i]) || t >= share_of(f.t_end[i])) continue;
      const double y = f.y[i] + f.rate[i] * (t - share_of(f.t_begin[i])), rho = std::exp(-y * y);
      weight += rho;
      for (int c = 0; c < 3; ++c) sum[c] += rho * p.shades[i].rgba[c];
    }
    const double scale = 1.0 / std::max(weight, 0.5);
    for (int c = 0; c < 3; ++c) exact[c] += sum[c] * scale / steps;
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel.rgba[c], exact[c], tolerance) << c;
  return p.counters.intervals;
}

TEST(Sweep, ADenseFrontTakesFewerPiecesThanEvents) {
  // 90 dB: what merging may cost at the most, and ten times what the steps do.
  EXPECT_LT(pieces_of_a_dense_front(1.0f, 3e-5), 700u);
}

TEST(Sweep, TheMoreAlikeItsMembersTheFewerPiecesAFrontTakes) {
  const std::uint64_t unlike = pieces_of_a_dense_front(1.0f, 3e-5);
  // A hundredth of the range, and no more than a tenth of the error.
  EXPECT_LT(1.3 * static_cast<double>(pieces_of_a_dense_front(0.01f, 3e-6)), static_cast<double>(unlike));
}

}  // namespace
}  // namespace swept
