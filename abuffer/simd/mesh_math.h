// Triangles at the places of a pixel: plain functions over plain arrays, one implementation per instruction
// set. All give the same bits. Source: model section 15.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/interval/pixel_places.h"

namespace SWEPT_API swept {
struct Texture;
}

namespace swept {

/// a·x + b·y + c of film coordinates, px.
struct Linear {
  double a, b, c;

  [[nodiscard]] double at(double x, double y) const { return a * x + b * y + c; }
};

/// A triangle at an instant, as a ray meets it.
struct PlacedTriangle {
  /// Over the edge opposite each corner: ≥ 0 inside, and changing by at most ½ within half a pixel. Of two
  /// triangles on either side of an edge one has exactly the other's negative.
  Linear edge[3];
  bool owns[3];          ///< places that lie on the edge
  float weight[3];       ///< times that: in proportion to the corner's share of the colour
  Linear inverse_depth;  ///< 1/z; of an orthographic camera what z is short of a depth behind all of the mesh
  float most_inverse;    ///< where 1/z is 0 or less or exceeds that, the near plane has cut the triangle off
  bool cut;              ///< that may happen
  bool plain;            ///< all corners have the first one's colour
  float rgba[3][4];      ///< premultiplied
  bool textured;         ///< uv[] matter, on
  const Texture* texture;
  float uv[3][2];  ///< of the corners, on the texture
};

/// A triangle and a pixel of a cell.
struct MeshFragment {
  std::uint32_t triangle;
  std::uint16_t pixel;
  std::uint16_t mask;  ///< places where the triangle is met
};

/// One triangle at each place.
struct MeshLayer {
  alignas(64) float inverse_depth[pixel_places];  ///< 0: none
  alignas(64) float triangle[pixel_places];       ///< whole numbers below 2²⁴; −1: none
};

struct MeshColors {
  alignas(64) float rgba[4][pixel_places];  ///< premultiplied, before any texture
  alignas(64) float uv[2][pixel_places];    ///< of textured triangles
};

struct MeshMath {
  const char* name;

  /// The places of the pixel about (x, y) where a triangle is met.
  std::uint32_t (*inside)(const PlacedTriangle& triangle, double x, double y);

  /// Of `count` fragments of that pixel what each place meets next: behind `last`, or at its depth and with a
  /// later triangle. False: nothing.
  bool (*meet_next)(const PlacedTriangle* triangles, const MeshFragment* fragments, std::size_t count,
                    double x, double y, const MeshLayer& last, MeshLayer& next);

  /// Of those places where `layer` has triangle `t`.
  void (*color)(const PlacedTriangle* triangles, std::uint32_t t, double x, double y, const MeshLayer& layer,
                MeshColors& colors);
};

/// Those this processor can run, in the order of sampled_maths().
struct MeshMaths {
  const MeshMath* first;
  std::size_t count;
};
[[nodiscard]] MeshMaths mesh_maths();

}  // namespace swept
