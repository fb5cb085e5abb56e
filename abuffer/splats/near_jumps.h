// Splats that pass the near plane on the film: they cover much of it, and all at once no more.
//
// Source: model section 14. A pixel that jumps by D at a time that nobody chose has a mean of N instants that
// is off by D/(2N) at most, and by D²/(12N²) in the mean of squares.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "abuffer/simd/splat_math.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/tiles/cells.h"

namespace swept {

/// A splat as it is when it passes the near plane, on the film; its pixels may be beyond it.
struct NearSplat {
  PlacedSplat splat;
  double x_first, x_last, y_first, y_last;  ///< px
  bool disc;
};

/// The splat `lane` of a packet, which is seen at just one of two frames. Nothing where it is not on the film
/// then.
[[nodiscard]] std::optional<NearSplat> at_near_plane(const Scene& scene, const SplatPackets& set,
                                                     std::size_t packet, std::size_t lane, double seen_at,
                                                     double unseen_at, const SplatMath& math,
                                                     const CellGrid& grid);

/// Of every cell the most that N instants are off by where `splats` appear or vanish, as a mean square over
/// R, G and B, times N². `colors` are three numbers of light for one of every `pitch_px` pixels, `columns` a
/// row.
[[nodiscard]] std::vector<double> near_jumps(const std::vector<NearSplat>& splats,
                                             const std::vector<float>& colors, std::size_t columns,
                                             int pitch_px, const SplatModel& model, bool linear,
                                             const CellGrid& grid);

}  // namespace swept
