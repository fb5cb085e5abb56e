// How far an image is from the reference, and whether a crop is the whole's bits.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include "splat/image.h"

namespace swept::test {

/// Root mean squares. Of images without a background, whose alpha is that of what is seen.
struct ImageDifference {
  double color = 0.0;  ///< over red, green, blue and alpha
  double depth = 0.0;  ///< relative to the reference's, times alpha; where just one sees something, its alpha
};

inline ImageDifference difference_of(const Image& image, const Image& reference) {
  EXPECT_EQ(image.rgba.size(), reference.rgba.size());
  EXPECT_EQ(image.depth.size(), reference.depth.size());
  if (image.rgba.size() != reference.rgba.size()) return {HUGE_VAL, HUGE_VAL};
  ImageDifference difference;
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    difference.color += std::pow(double{image.rgba[i]} - double{reference.rgba[i]}, 2);
  for (std::size_t p = 0; p < image.depth.size(); ++p) {
    const double alpha = std::max(image.rgba[4 * p + 3], reference.rgba[4 * p + 3]);
    const double depth = image.depth[p], truth = reference.depth[p];
    EXPECT_FALSE(std::isnan(depth));
    if (!std::isfinite(depth) && !std::isfinite(truth)) continue;
    const bool both = std::isfinite(depth) && std::isfinite(truth);
    difference.depth += std::pow(alpha * (both ? (depth - truth) / truth : 1.0), 2);
  }
  difference.color = std::sqrt(difference.color / static_cast<double>(image.rgba.size()));
  difference.depth = std::sqrt(difference.depth / static_cast<double>(image.depth.size()));
  return difference;
}

/// PSNR over red, green, blue and alpha for peak 1, at most 180.
inline double decibels(const Image& image, const Image& reference) {
  return -20.0 * std::log10(std::max(difference_of(image, reference).color, 1e-9));
}

/// The crop is the window that `film` asks for, and its pixels and depths are the whole's, bit for bit.
inline testing::AssertionResult is_crop_of(const Image& crop, const Image& whole, const Film& film) {
  if (crop.x != film.crop_x || crop.y != film.crop_y || crop.width != film.crop_width ||
      crop.height != film.crop_height)
    return testing::AssertionFailure() << "another window";
  const auto same = [](float a, float b) {
    return a == b && std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
  };
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x) {
      const auto a = static_cast<std::size_t>(y * crop.width + x),
                 b = static_cast<std::size_t>((y + crop.y) * whole.width + x + crop.x);
      if (!std::equal(&crop.rgba[4 * a], &crop.rgba[4 * a] + 4, &whole.rgba[4 * b], same))
        return testing::AssertionFailure() << "another colour at " << x << ", " << y << " of the crop";
      if (!crop.depth.empty() && !same(crop.depth[a], whole.depth[b]))
        return testing::AssertionFailure() << "another depth at " << x << ", " << y << " of the crop";
    }
  return testing::AssertionSuccess();
}

}  // namespace swept::test
