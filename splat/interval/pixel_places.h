// The places of a pixel at which triangles are sampled. Source: model section 15.
#pragma once

#include "splat/export.h"

namespace SWEPT_API swept {

inline constexpr int pixel_places = 16;

/// Offsets from the pixel's centre, px, in (−½, ½): in each of 16 columns and of 16 rows there is one.
struct PixelPlaces {
  alignas(64) float x[pixel_places], y[pixel_places];

  constexpr PixelPlaces() : x(), y() {
    for (int i = 0; i < pixel_places; ++i) {
      const int reversed = (i & 1) << 3 | (i & 2) << 1 | (i & 4) >> 1 | (i & 8) >> 3;
      x[i] = (static_cast<float>(i) + 0.5f) / pixel_places - 0.5f;
      y[i] = (static_cast<float>(reversed) + 0.5f) / pixel_places - 0.5f;
    }
  }
};
inline constexpr PixelPlaces places_in_pixel{};

}  // namespace swept
