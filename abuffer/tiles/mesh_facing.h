// Which side of a moving triangle is seen.
//
// Corners p, q, r of it before an eye at 0 show its back where p·(q × r) is above 0, or below for a mirrored
// mesh: every ray that meets it in front of the eye agrees. On Bézier paths of degree n that is a polynomial
// of degree 3n (Munkberg and Akenine-Möller 2011, which Rönnow et al. 2021, section 4.4, name as the precise
// method).
#pragma once

#include <cstddef>

#include "abuffer/sources/moving_mesh.h"

namespace swept {

/// Whether a triangle shows its back from the beginning to the end of a stretch, by its polynomial's
/// coefficients: it may say no where that is so, but never yes where it is not. Rays are parallel if
/// `orthographic`.
[[nodiscard]] bool always_faces_away(const MovingMesh& mesh, std::size_t stretch, std::size_t triangle,
                                     bool orthographic);

/// Whether it shows its back when the exposure of `mesh` begins and when it ends. It may show its front
/// between them.
[[nodiscard]] bool faces_away_at_both_ends(const MovingMesh& mesh, std::size_t triangle, bool orthographic);

}  // namespace swept
