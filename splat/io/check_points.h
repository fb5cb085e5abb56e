// What points of a caller have to be before anything is computed from them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "splat/result.h"
#include "splat/surfel.h"

namespace swept {

/// "has 3 entries where there are 4 points".
[[nodiscard]] Error wrong_count(const std::string& array, std::size_t found, std::size_t points);

/// Errors: a position that is not finite, named by its index.
[[nodiscard]] Status check_positions(const std::vector<Eigen::Vector3d>& positions);

/// Errors: a corner that is no point, named by its triangle's index.
[[nodiscard]] Status check_triangles(const std::vector<std::array<std::uint32_t, 3>>& triangles,
                                     std::size_t points);

/// Discs that were estimated may be larger than float can say. Errors: an axis that is not finite.
[[nodiscard]] Status check_axes(const SurfelPose& pose);

}  // namespace swept
