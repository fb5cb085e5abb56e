// Triangles of a mesh at an instant, made ready to meet rays.
//
// Edges are planes through the eye, so that a triangle may pass through it and nothing has to be clipped
// (Olano and Greer 1997, Triangle Scan Conversion Using 2D Homogeneous Coordinates).
#pragma once

#include <cstddef>
#include <optional>

#include "abuffer/simd/mesh_math.h"
#include "abuffer/sources/mesh_instant.h"

namespace swept {

/// Nothing of a triangle that is seen edge-on, or from behind and may not be.
[[nodiscard]] std::optional<PlacedTriangle> place_triangle(const MeshInstant& mesh, std::size_t triangle);

}  // namespace swept
