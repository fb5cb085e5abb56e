// At how many instants a cell is looked at, and when that is enough.
//
// Source: model section 12. Where a pixel's signal is smooth the midpoint rule converges faster than any
// power until there is about one instant per pixel of motion; from there silhouettes lead, at 1/N.
#pragma once

#include <span>

#include "abuffer/tiles/cells.h"

namespace swept {

/// Instants a cell begins with, of a ladder of numbers, for motion across it and the frame's error in dB.
[[nodiscard]] int first_instants(float motion_px, double max_error_db);

/// Motion that stands for all of a cell's.
[[nodiscard]] float typical_motion(const PacketBins& bins, std::span<const PacketRef> packets);

}  // namespace swept
