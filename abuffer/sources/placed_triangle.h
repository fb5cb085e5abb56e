// A triangle at an instant, as a ray meets it.
//
// Edges are planes through the eye, so that a triangle may pass through it and nothing has to be clipped
// (Olano and Greer 1997, Triangle Scan Conversion Using 2D Homogeneous Coordinates).
#pragma once

#include <cstddef>
#include <optional>

#include "abuffer/sources/mesh_instant.h"

namespace swept {

/// a·x + b·y + c of film coordinates, px.
struct Linear {
  double a, b, c;

  [[nodiscard]] double at(double x, double y) const { return a * x + b * y + c; }
};

struct PlacedTriangle {
  /// Over the edge opposite each corner: ≥ 0 inside, and changing by at most ½ within half a pixel. Of two
  /// triangles on either side of an edge one has exactly the other's negative.
  Linear edge[3];
  bool owns[3];          ///< places that lie on the edge
  double weight[3];      ///< times that: in proportion to the corner's share of the colour
  Linear inverse_depth;  ///< 1/z
  float nearest;         ///< where 1/z exceeds that, the near plane has cut the triangle off
  bool cut;              ///< that may happen
  bool plain;            ///< all corners have the first one's colour
  float rgba[3][4];      ///< premultiplied

  /// Nothing of a triangle that is seen edge-on, or from behind and may not be.
  static std::optional<PlacedTriangle> make(const MeshInstant& mesh, std::size_t triangle);
};

}  // namespace swept
