// The paths of a cloud's points as Bézier curves of one degree, in stretches between keys (model section 7).
//
// Source: Gribel et al. 2013, section 3. A polynomial of degree d has a blossom f(t₁ … t_d), symmetric,
// affine in each argument, and f(t … t) is its value; over [a, b] its control points are f(a … a, b … b). How
// far it leaves its chord follows from their second differences.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "splat/export.h"
#include "splat/surfel.h"

namespace SWEPT_API swept {

/// The degree of the paths: 1 where they are straight. Turning discs do not count.
[[nodiscard]] std::size_t path_degree(const SurfelCloud& cloud);

/// Where the paths are at `frame`.
[[nodiscard]] PathWeights path_weights(const SurfelCloud& cloud, double frame);

/// The blossom of the stretch that `within` lies in, at `frames`, path_degree() of them. At a key the stretch
/// before it counts.
[[nodiscard]] PathWeights path_blossom(const SurfelCloud& cloud, double within,
                                       std::span<const double> frames);

/// Control points of the paths between frames `first` < `last`, between which no key lies: path_degree() + 1.
[[nodiscard]] std::vector<PathWeights> path_controls(const SurfelCloud& cloud, double first, double last);

/// Frames in ]first, last[ at which the paths are not smooth, increasing.
[[nodiscard]] std::vector<double> path_corners(const SurfelCloud& cloud, double first, double last);

}  // namespace swept
