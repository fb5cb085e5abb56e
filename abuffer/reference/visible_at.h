// What rays through the places of pixels meet first at some instants: every triangle near them is tried.
#pragma once

#include <vector>

#include "abuffer/visibility.h"

namespace swept::reference {

/// Of a valid scene of triangles alone. Runs in the caller's task arena.
[[nodiscard]] VisibleTriangles triangles_at(const Scene& scene, const std::vector<double>& times);

}  // namespace swept::reference
