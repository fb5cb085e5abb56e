#include "abuffer/resolve/still.h"

#include <algorithm>

namespace swept {

void StillPixel::resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
                         std::uint32_t* indices, std::size_t count, PixelSum& pixel) const {
  std::sort(indices, indices + count, [&](std::uint32_t a, std::uint32_t b) {
    return fragments.z[a] != fragments.z[b] ? fragments.z[a] < fragments.z[b] : a < b;
  });
  float transmittance = 1.0f;
  for (std::size_t first = 0; first < count && transmittance > opaque_transmittance;) {
    const std::uint32_t nearest = indices[first];
    const float limit = fragments.z[nearest] + shades[fragments.kernel[nearest]].depth_tolerance;
    SurfaceSum surface;
    std::size_t i = first;
    for (; i < count && fragments.z[indices[i]] <= limit; ++i) {
      const std::uint32_t f = indices[i];
      const float rho = fragments.peak[f];
      const Shade& shade = shades[fragments.kernel[f]];
      surface.weight += rho;
      for (int c = 0; c < 4; ++c) surface.rgba[c] += rho * shade.rgba[c];
      surface.depth += rho * fragments.z[f];
    }
    model_.add(surface, 1.0, transmittance, pixel);
    first = i;
  }
  model_.finish(pixel);
}

}  // namespace swept
