// What of a pixel's light comes from where in depth.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/export.h"

namespace SWEPT_API swept {

/// A stretch of depth, camera-space units, and what of the pixel's premultiplied RGBA is seen there.
struct DepthPart {
  std::uint32_t slab;
  float near, far;  ///< within the slab
  float rgba[4];
};

/// Gathers light by depth, in slabs that are the same for all pixels: 128 to an octave, cut where a float's
/// upper 16 bits change. So parts never overlap, and what they hold depends on no order of tiles or threads.
class DepthSum {
 public:
  /// Light that is spread evenly from one depth to another, either way round; from == to is a point. Depths
  /// are above 0. May take light away from where other calls put it.
  void add(double from, double to, const double (&rgba)[4]);

  [[nodiscard]] const std::vector<DepthPart>& parts() const { return parts_; }  ///< front to back
  [[nodiscard]] std::vector<DepthPart>& parts() { return parts_; }

 private:
  void put(std::uint32_t slab, float near, float far, const double (&rgba)[4], double share);

  std::vector<DepthPart> parts_;
};

}  // namespace swept
