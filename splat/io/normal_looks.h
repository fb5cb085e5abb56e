// Colours by normals of discs that turn while the shutter is open.
#pragma once

#include <cstddef>

#include "splat/surfel.h"

namespace swept::io {

/// Gives a cloud that is coloured by its normals, on the sides that they have at key `reference`, the colours
/// of its normals over frames [first, last] as looks: at its keys, or so often that what spins turns by some
/// 10° from one to the next. Leaves it as it is where no colour would change by as much as an 8-bit step is.
void turn_colors(std::size_t reference, double first, double last, SurfelCloud& cloud);

}  // namespace swept::io
