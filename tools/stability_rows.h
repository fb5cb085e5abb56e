// The parts of the stability table. Each appends its rows, of about `points` seeded points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/stability_table.h"

namespace swept::stability {

/// The mean of exp(−y²): splat/kernel_integral.h, and the float form in the sweep's inner loop.
void add_integral_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows);
/// Coordinates and depth along a ray, by kernel: KernelPlane.
void add_coordinate_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows);
/// Times, peak and depth of a fragment: intersect_tube.
void add_tube_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows);
/// ∫ρ over a fragment, from its coordinates on: intersect_tube and interval_integral together.
void add_fragment_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows);
/// Where two linear depths cross.
void add_crossing_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows);
/// Weight and size of a filtered disc.
void add_filter_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows);

}  // namespace swept::stability
