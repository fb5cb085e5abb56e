// When the places of a pixel are inside a triangle whose corners move on straight lines: plain functions over
// plain arrays, one implementation per instruction set. All give the bits of TriangleStretch::meet(), which
// is where the formulas come from. Source: Gribel et al. 2013, section 3.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/interval/pixel_places.h"

namespace swept {

/// Edge functions of degree 2: each points to three normals of three numbers, control points in time.
struct StraightEdges {
  const double* edge[3];
  bool shows_above, shows_below;  ///< whether it is seen where edge functions are above 0, and below
};

/// In shares of the triangle's stretch.
struct MetPlaces {
  std::uint32_t above, below;  ///< places that meet it once with all edge functions above 0, and below: from
                               ///< first[0] to last[0], and from first[1] to last[1]
  std::uint32_t unknown;       ///< places that have to be looked at by themselves; in neither of the others
  alignas(64) double first[2][pixel_places], last[2][pixel_places];
};

/// Depths of triangles on straight paths while a ray meets them.
struct DepthChords {
  static constexpr int most = 8;

  alignas(64) double since[most];  ///< of the triangle's stretch
  alignas(64) double until[most];
  alignas(64) double begin[most];  ///< of the time at which the ray meets it
  alignas(64) double end[most];
  alignas(64) double above[4][most];  ///< depths over the stretch are quotients of these, Bernstein form
  alignas(64) double below[3][most];
  alignas(64) double nearest[most];  ///< depths are clamped to these
  alignas(64) double farthest[most];
  // What is found:
  alignas(64) double z_begin[most];  ///< as that time begins, half-way, and as it ends
  alignas(64) double z_middle[most];
  alignas(64) double z_end[most];
  alignas(64) double bow[most];  ///< u of the way depths are off the chord by u (1 − u) times that at most
  alignas(64) double per_time[most];  ///< 1 over how long that time is
};

struct EdgeMath {
  const char* name;

  /// Rays are (x, y, 1). What `met` has of other places than it names is anything.
  void (*meet)(const StraightEdges& edges, const double* x, const double* y, MetPlaces& met);
  /// Of all of them; what cannot be told has a bow of infinity.
  void (*chords)(DepthChords& chords);
};

/// Those this processor can run, the plain one first and the fastest last.
struct EdgeMaths {
  const EdgeMath* first;
  std::size_t count;

  [[nodiscard]] const EdgeMath& fastest() const { return first[count - 1]; }
};
[[nodiscard]] EdgeMaths edge_maths();

}  // namespace swept
