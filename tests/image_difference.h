// How far an image is from the reference.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

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

}  // namespace swept::test
