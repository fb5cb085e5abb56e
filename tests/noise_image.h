// An image of which no two pixels are alike.
#pragma once

#include <cstddef>
#include <random>

#include "splat/image.h"

namespace swept::test {

/// Colours and alpha in [0, 1), depths in [1, 10); always the same.
inline Image noise(int x, int y, int width, int height, int film_width, int film_height) {
  Image image{x, y, width, height, film_width, film_height, {}, {}};
  std::mt19937 generator(7);
  const auto unit = [&] { return static_cast<float>(generator() >> 8) * 0x1p-24f; };
  for (std::size_t i = 0; i < 4 * image.pixel_count(); ++i) image.rgba.push_back(unit());
  for (std::size_t i = 0; i < image.pixel_count(); ++i) image.depth.push_back(1.0f + 9.0f * unit());
  return image;
}

}  // namespace swept::test
