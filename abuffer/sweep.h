// A pixel's fragments, resolved exactly in time and depth.
//
// Source: model section 4; Carpenter's A-buffer as adapted by Heinzle et al. 2010, section 4.4, and the
// events of Rönnow et al. 2021, Algorithm 1. Heinzle walks the intervals and trims the occluded ones; here
// the walk is over events, so that between two of them the surfaces are made of the same fragments, and
// normalisation is per interval instead of per pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "abuffer/composite.h"
#include "abuffer/fragments.h"

namespace swept {

struct SweepCounters {
  std::uint64_t intervals = 0;    ///< pieces of time resolved
  std::uint64_t crossings = 0;    ///< of these, ended by a change of the surfaces' members
  std::uint64_t subdivided = 0;   ///< of these, ended because weights or coverage change too much within
  std::uint64_t evaluations = 0;  ///< fragments integrated, summed over intervals
};

class PixelSweep {
 public:
  explicit PixelSweep(const SurfaceModel& model) : model_(model) {}

  /// Resolves the `count` fragments `indices` of `fragments`, in any order but one that does not depend on
  /// the order of the scene's points. Adds to `pixel` and `counters`.
  void resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades,
               const std::uint32_t* indices, std::size_t count, PixelSum& pixel, SweepCounters& counters);

 private:
  /// A fragment that covers the pixel now, gathered from the arrays.
  struct Active {
    std::uint32_t fragment;
    float t_begin, y, rate, peak, z, z_rate;
    const Shade* shade;
  };
  /// Members [first, last) of order_, and their sums over the current interval.
  struct Surface {
    std::size_t first, last;
    SurfaceSum sum;
    float scale;
  };

  void resolve_interval(float begin, float end, PixelSum& pixel, SweepCounters& counters);
  float build_surfaces(float begin, float end, SweepCounters& counters);
  std::size_t gather_nearest(std::size_t first, float begin, float& end, SweepCounters& counters);
  void means_of(std::size_t first, std::size_t last, float begin, float end);
  float sum_at(std::size_t first, std::size_t last, float time);
  float measure(Surface& surface, float begin, float end, SweepCounters& counters);

  SurfaceModel model_;
  std::vector<std::uint64_t> begins_, ends_;  ///< event time's bits above, place in `indices` below
  std::vector<std::uint32_t> slot_;           ///< place in active_ of each place in `indices`
  std::vector<std::uint32_t> place_;          ///< and back
  std::vector<Active> active_;
  std::vector<std::uint32_t> order_;
  std::vector<Surface> surfaces_;
  std::vector<float> y_, span_, peak_, mean_, z_begin_, z_end_;
};

}  // namespace swept
