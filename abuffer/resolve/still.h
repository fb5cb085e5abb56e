// A pixel in which nothing moves: no intervals, no erf.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "splat/export.h"
#include "splat/interval/composite.h"
#include "splat/interval/fragments.h"

namespace SWEPT_API swept {

class StillPixel {
 public:
  explicit StillPixel(const SurfaceModel& model) : model_(model) {}

  /// Resolves the `count` fragments `indices` of `fragments`, all is_still(), as they are at shutter time
  /// `time`: their depth tolerances may change. `indices` is reordered; what order it comes in matters only
  /// between fragments of equal depth.
  void resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades, std::uint32_t* indices,
               std::size_t count, PixelSum& pixel, float time = 0.0f) const;

 private:
  SurfaceModel model_;
};

}  // namespace swept
