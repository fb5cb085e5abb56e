// A packet's splats at one frame, lane by lane.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "abuffer/simd/splat_math.h"

namespace swept {

struct PlacedLanes {
  std::uint32_t seen = 0;
  std::array<PlacedSplat, static_cast<std::size_t>(packet_size)> lanes;
};

inline PlacedLanes placed_lanes(const SplatMath& math, const SplatFields& fields, const SplatView& view,
                                const SplatOrigin& origin) {
  PlacedLanes placed;
  std::array<PlacedSplat, static_cast<std::size_t>(packet_size)> compact;
  placed.seen = math.place(fields, view, origin, compact.data());
  std::size_t next = 0;
  for (std::uint32_t rest = placed.seen; rest != 0; rest &= rest - 1)
    placed.lanes[static_cast<std::size_t>(std::countr_zero(rest))] = compact[next++];
  return placed;
}

/// A vector on the film in standard deviations of a splat.
inline double in_deviations(const PlacedSplat& s, double dx, double dy) {
  constexpr double half_log2_e = 0.72134752044448170;
  const double u = double{s.ux} * dx + double{s.uy} * dy, v = double{s.vy} * dy;
  return std::sqrt((u * u + v * v) / half_log2_e);
}

}  // namespace swept
