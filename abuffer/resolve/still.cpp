#include "abuffer/resolve/still.h"

#include <algorithm>

namespace swept {

void StillPixel::resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
                         std::uint32_t* indices, std::size_t count, PixelSum& pixel, float time) const {
  std::uint32_t sides = 0;
  for (std::size_t i = 0; i < count; ++i)
    sides |= static_cast<std::uint32_t>(shades[fragments.kernel[indices[i]]].side);
  const bool mixed = both_sides(sides);
  const auto side_of = [&](std::uint32_t f) { return shades[fragments.kernel[f]].side; };
  std::sort(indices, indices + count, [&](std::uint32_t a, std::uint32_t b) {
    if (fragments.z[a] != fragments.z[b]) return fragments.z[a] < fragments.z[b];
    if (mixed && side_of(a) != side_of(b)) return rank_of(side_of(a)) < rank_of(side_of(b));
    return a < b;
  });
  float transmittance = 1.0f;
  for (std::size_t first = 0; first < count && transmittance > opaque_transmittance;) {
    const std::uint32_t nearest = indices[first];
    const float limit = fragments.z[nearest] + shades[fragments.kernel[nearest]].tolerance_at(time);
    std::size_t last = first;
    while (last < count && fragments.z[indices[last]] <= limit) ++last;
    // What shows the other side is another surface, behind this one.
    if (mixed)
      last = static_cast<std::size_t>(
          std::stable_partition(indices + first, indices + last,
                                [&](std::uint32_t f) { return !both_sides(side_of(f), side_of(nearest)); }) -
          indices);
    SurfaceSum surface;
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t f = indices[i];
      const float rho = fragments.peak[f];
      const Shade& shade = shades[fragments.kernel[f]];
      surface.weight += rho;
      for (int c = 0; c < 4; ++c) surface.rgba[c] += rho * shade.rgba[c];
      surface.depth += rho * fragments.z[f];
    }
    model_.add(surface, 1.0, transmittance, pixel);
    first = last;
  }
  model_.finish(pixel);
}

}  // namespace swept
