// The points of a cloud by what their paths call for, so that those few that curve, spin or come and go are
// all that pay for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "splat/surfel.h"

namespace swept {

/// Points that are alike in this.
struct PathGroup {
  bool curved = false;                ///< paths bend between two of the frames
  bool spins = false;                 ///< discs turn at rates of their own
  bool mortal = false;                ///< begin or end in the exposure, or are not there
  std::vector<std::uint32_t> points;  ///< increasing

  [[nodiscard]] std::size_t degree(const SurfelCloud& cloud) const;
};

/// Groups of a cloud's points, none of them empty, over the exposure from frames.front() to frames.back();
/// all corners of paths are among `frames`. A path that leaves its chord by less than 2⁻²⁰ of the disc's size
/// is straight. Depends on each point alone. Runs in the caller's task arena.
[[nodiscard]] std::vector<PathGroup> path_groups(const SurfelCloud& cloud, const std::vector<double>& frames);

}  // namespace swept
