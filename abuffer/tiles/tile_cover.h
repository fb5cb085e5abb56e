// What opaque triangles already hide of a tile: the far plane behind which nothing need be looked for.
// Source: Gribel et al. 2013, section 4.2, and Boulos et al. 2010, whose pyramid over time and depth this
// does for single places.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "splat/interval/pixel_places.h"

namespace swept {

/// A thread's. Places are counted as intervals count them, pixel by pixel. Surfaces of several meshes are
/// mixed over the pixel, not at its places (model section 15.4): at a place a mesh hides itself alone, and
/// others only where it is seen at all places of the pixel.
class TileCover {
 public:
  void start(std::size_t pixels) {
    places_.assign(pixels * pixel_places, Place{});
    pixels_.assign(pixels, Pixel{});
    open_pixels_ = pixels;
    depth_ = 0.0f;
  }

  /// Something opaque of a mesh no farther than `farthest` is seen from `begin` to `end`, of a row that is
  /// exposed from `from` to `to`.
  void add(std::uint32_t mesh, std::size_t place, double begin, double end, float farthest, double from,
           double to) {
    Place& p = places_[place];
    if (p.count == 0) p.mesh = mesh;
    if (p.closed || p.mesh != mesh) return;
    p.depth = std::max(p.depth, farthest);
    // Spans that it touches become one with it.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < p.count; ++i) {
      if (p.end[i] < begin || p.begin[i] > end) {
        p.begin[kept] = p.begin[i];
        p.end[kept++] = p.end[i];
        continue;
      }
      begin = std::min(begin, p.begin[i]);
      end = std::max(end, p.end[i]);
    }
    // A span for which there is no room is forgotten: then less is hidden.
    if (kept < most_spans) {
      p.begin[kept] = begin;
      p.end[kept++] = end;
    }
    p.count = static_cast<std::uint8_t>(kept);
    if (!(begin <= from && end >= to)) return;
    p.closed = true;
    Pixel& pixel = pixels_[place / pixel_places];
    if (pixel.closed == 0) pixel.mesh = mesh;
    if (pixel.mesh != mesh) return;
    pixel.depth = std::max(pixel.depth, p.depth);
    if (++pixel.closed < pixel_places) return;
    --open_pixels_;
    depth_ = std::max(depth_, pixel.depth);
  }

  /// Whether what a mesh has at `nearest` or behind it is never seen there; and what any mesh has.
  [[nodiscard]] bool hides_place(std::uint32_t mesh, std::size_t place, float nearest) const {
    const Place& p = places_[place];
    return p.closed && p.mesh == mesh && nearest > p.depth;
  }
  [[nodiscard]] bool hides_pixel(std::size_t pixel, float nearest) const {
    return pixels_[pixel].closed == pixel_places && nearest > pixels_[pixel].depth;
  }
  [[nodiscard]] bool hides_tile(float nearest) const { return open_pixels_ == 0 && nearest > depth_; }

 private:
  static constexpr std::size_t most_spans = 4;
  struct Place {
    double begin[most_spans], end[most_spans];
    float depth = 0.0f;  ///< of the farthest of what covers it
    std::uint32_t mesh = 0;
    std::uint8_t count = 0;
    bool closed = false;  ///< at all times
  };
  struct Pixel {
    float depth = 0.0f;
    std::uint32_t mesh = 0;
    int closed = 0;
  };

  std::vector<Place> places_;
  std::vector<Pixel> pixels_;
  std::size_t open_pixels_ = 0;
  float depth_ = 0.0f;
};

}  // namespace swept
