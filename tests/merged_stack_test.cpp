// Stacks of surfaces in which fragments begin and end: against the model at many instants, and that pieces
// are fewer than events.
#include "abuffer/resolve/merged_stack.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "abuffer/resolve/sweep.h"

namespace swept {
namespace {

struct Crowd {
  FragmentArrays fragments;
  std::vector<Shade> shades;
  SweepCounters counters;
  ImageModel model;
};

/// Fragments at all depths, which come and go as discs do that pass a pixel: each is there where |y| ≤ √3.
Crowd crowd_of(int count, float weight, float tolerance, float steepest, bool sides, int seed) {
  Crowd crowd;
  std::mt19937 random(static_cast<unsigned>(seed));
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 8) * 0x1p-24;
  };
  crowd.fragments.ensure(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) {
    const double rate = uniform(2.0, 9.0), middle = uniform(-0.3, 1.3), root_three = std::sqrt(3.0);
    const double begin = std::max(0.0, middle - root_three / rate),
                 end = std::min(1.0, middle + root_three / rate);
    if (!(begin < end)) continue;
    FragmentArrays& f = crowd.fragments;
    const std::size_t i = f.count++;
    f.pixel[i] = 0;
    f.kernel[i] = static_cast<std::uint32_t>(crowd.shades.size());
    f.t_begin[i] = ticks_of(begin);
    f.t_end[i] = ticks_of(end);
    f.rate[i] = static_cast<float>(rate);
    f.y[i] = static_cast<float>((begin - middle) * rate);
    f.peak[i] = weight * static_cast<float>(uniform(0.2, 1.0));
    f.z[i] = static_cast<float>(uniform(1.0, 2.0));
    f.z_rate[i] = static_cast<float>(uniform(-steepest, steepest));
    const auto alpha = static_cast<float>(uniform(0.5, 1.0));
    crowd.shades.push_back({{alpha * static_cast<float>(uniform(0.0, 1.0)), 0.5f * alpha, 0.0f, alpha},
                            tolerance,
                            sides ? (random() % 2 ? Side::front : Side::back) : Side::unknown});
  }
  return crowd;
}

PixelSum sweep(Crowd& crowd) {
  std::vector<std::uint32_t> indices(crowd.fragments.count);
  std::iota(indices.begin(), indices.end(), 0u);
  PixelSum pixel;
  PixelSweep(SurfaceModel(crowd.model))
      .resolve(crowd.fragments, crowd.shades, indices.data(), indices.size(), pixel, crowd.counters);
  return pixel;
}

/// Model sections 1.2 to 1.5 at the middles of `instants` parts of the exposure.
PixelSum at_instants(const Crowd& crowd, int instants) {
  struct At {
    double z, rho;
    const Shade* shade;
  };
  PixelSum mean;
  std::vector<At> all, behind;
  for (int n = 0; n < instants; ++n) {
    const double time = (n + 0.5) / instants;
    all.clear();
    const FragmentArrays& f = crowd.fragments;
    for (std::size_t i = 0; i < f.count; ++i) {
      const double since = time - share_of(f.t_begin[i]);
      if (since < 0.0 || time >= share_of(f.t_end[i])) continue;
      const double y = f.y[i] + f.rate[i] * since;
      all.push_back({f.z[i] + f.z_rate[i] * since, f.peak[i] * std::exp(-y * y), &crowd.shades[f.kernel[i]]});
    }
    std::sort(all.begin(), all.end(), [](const At& a, const At& b) { return a.z < b.z; });
    double left = 1.0;
    while (!all.empty()) {
      const At nearest = all.front();
      double weight = 0.0, rgba[4] = {0.0, 0.0, 0.0, 0.0}, depth = 0.0;
      behind.clear();
      for (const At& a : all) {
        if (a.z > nearest.z + double{nearest.shade->depth_tolerance} ||
            both_sides(a.shade->side, nearest.shade->side)) {
          behind.push_back(a);
          continue;
        }
        weight += a.rho;
        depth += a.rho * a.z;
        for (int c = 0; c < 4; ++c) rgba[c] += a.rho * double{a.shade->rgba[c]};
      }
      const double per = 1.0 / std::max(weight, crowd.model.edge_weight), share = left / instants;
      for (int c = 0; c < 4; ++c) mean.rgba[c] += share * rgba[c] * per;
      mean.depth += share * rgba[3] * per * depth / weight;
      left *= 1.0 - rgba[3] * per;
      all.swap(behind);
    }
  }
  return mean;
}

void expect_as_the_model(Crowd crowd, const char* what) {
  const PixelSum pixel = sweep(crowd), truth = at_instants(crowd, 8192);
  // What midpoints are off by where fragments begin and end is a random walk of steps of at most 0.05 weight
  // of at most 1/2 of a part; and 90 dB.
  constexpr double error = 3e-5;
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(pixel.rgba[c], truth.rgba[c], error) << what << ", channel " << c;
  EXPECT_NEAR(pixel.depth, truth.depth, 2.0 * error) << what;
  EXPECT_GT(crowd.counters.merged, 0u) << what;
  EXPECT_LT(crowd.counters.intervals, crowd.fragments.count) << what << ": half of the events";
}

TEST(MergedStack, PointsInABoxAreAsTheModelSays) {
  for (const int seed : {1, 2, 3})
    expect_as_the_model(crowd_of(300, 0.07f, 0.008f, 0.05f, false, seed), "box");
}

TEST(MergedStack, ManyToASurfaceAreAsTheModelSays) {
  for (const int seed : {4, 5}) expect_as_the_model(crowd_of(900, 0.02f, 0.06f, 0.02f, false, seed), "dense");
}

TEST(MergedStack, SidesAreKeptApart) {
  for (const int seed : {6, 7})
    expect_as_the_model(crowd_of(300, 0.05f, 0.01f, 0.05f, true, seed), "two sides");
}

TEST(MergedStack, WhatCoversIsClamped) {
  // Each covers some of the pixel by itself, and all together hide what is behind.
  Crowd crowd = crowd_of(400, 0.3f, 0.05f, 0.02f, false, 8);
  const PixelSum pixel = sweep(crowd), truth = at_instants(crowd, 8192);
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(pixel.rgba[c], truth.rgba[c], 2e-4) << c;
}

}  // namespace
}  // namespace swept
