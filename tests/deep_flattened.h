// Samples by depth put together again.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "splat/deep_image.h"
#include "splat/image.h"

namespace swept::test {

/// Floats, of sums in another order.
inline constexpr double deep_rounding = 1e-5;

/// With samples by depth, which are valid; nothing after a failure.
inline Rendered render_deep(const Scene& scene, AbufferOptions options = {},
                            const RenderControl& control = {}) {
  options.deep = true;
  Result<Rendered> rendered = render_abuffer(scene, options, control);
  if (!rendered) {
    ADD_FAILURE() << rendered.error().message();
    return {};
  }
  EXPECT_TRUE(rendered->deep.has_value());
  const Status valid = rendered->deep->validate();
  EXPECT_TRUE(valid.ok()) << valid.error().message();
  return *std::move(rendered);
}

/// The most by which R, G, B or A of `deep`, front over back, is off from the picture.
inline double flattened_error(const DeepImage& deep, const Image& image) {
  EXPECT_EQ(deep.pixel_count(), image.pixel_count());
  double worst = 0.0;
  for (std::size_t pixel = 0; pixel < deep.pixel_count(); ++pixel) {
    double flat[4] = {0.0, 0.0, 0.0, 0.0};
    for (std::size_t i = deep.first[pixel]; i < deep.first[pixel + 1]; ++i) {
      const double left = 1.0 - flat[3];
      for (std::size_t c = 0; c < 4; ++c) flat[c] += left * double{deep.rgba[4 * i + c]};
    }
    for (std::size_t c = 0; c < 4; ++c)
      worst = std::max(worst, std::abs(flat[c] - double{image.rgba[4 * pixel + c]}));
  }
  return worst;
}

}  // namespace swept::test
