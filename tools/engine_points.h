// How the sampled engine's time grows with the number of points.
#pragma once

#include <cstddef>

#include "splat/render_control.h"

namespace swept {

/// Prints a table of CPU seconds for spheres of 10⁴ to `most` points, still and moving 30 px. Returns 0, or 1
/// after an error.
int print_times_by_points(std::size_t most, const RenderControl& control);

}  // namespace swept
