// The parts of the stability table. Each adds the jobs that make its rows, of about `points` seeded points;
// jobs share nothing and may run at the same time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "tools/stability_table.h"

namespace swept::stability {

template <class T>
inline constexpr const char* type_name = sizeof(T) == 4 ? "float" : "double";
template <class T>
inline constexpr double unit_roundoff = std::numeric_limits<T>::epsilon() / 2;

inline constexpr const char* case_range = "model section 10, 1000 px of focal length";

using Job = std::function<std::vector<Row>()>;

/// The mean of exp(−y²): splat/kernel/kernel_integral.h, and the sweep's own in every build.
void add_integral_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs);
/// Coordinates and depth along a ray, by kernel: KernelPlane.
void add_coordinate_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs);
/// Times, peak and depth of a fragment: intersect_tube.
void add_tube_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs);
/// ∫ρ over a fragment, from its coordinates on: intersect_tube and interval_integral together.
void add_fragment_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs);
/// Where two linear depths cross.
void add_crossing_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs);
/// Weight and size of a filtered disc.
void add_filter_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs);
/// When a ray crosses the edges of triangles that move on lines and on parabolas, by both solvers.
void add_edge_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs);

}  // namespace swept::stability
