// A pixel's light by depth.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/export.h"

namespace SWEPT_API swept {

/// A range of depth, camera-space units, and the part of the pixel's premultiplied RGBA that is seen there.
struct DepthPart {
  std::uint32_t slab;  ///< the upper 16 bits of its depths as floats
  float near, far;     ///< within the slab
  float rgba[4];
};

/// Gathers light by depth, in slabs that are the same for all pixels: 128 to an octave, cut where a float's
/// upper 16 bits change. So parts never overlap, and what they hold depends on no order of tiles or threads.
class DepthSum {
 public:
  /// Adds light that is spread evenly from one depth to another, in either order; from == to is a point.
  /// Depths are above 0. The light may be negative, to take away what other calls added.
  void add(double from, double to, const double (&rgba)[4]);

  [[nodiscard]] const std::vector<DepthPart>& parts() const { return parts_; }  ///< front to back
  [[nodiscard]] std::vector<DepthPart>& parts() { return parts_; }

 private:
  void put(std::uint32_t slab, float near, float far, const double (&rgba)[4], double share);

  std::vector<DepthPart> parts_;
};

}  // namespace swept
