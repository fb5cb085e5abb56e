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

  /// Resolves the `count` fragments `indices` of `fragments`, all is_still(). `indices` is reordered; what
  /// order it comes in matters only between fragments of equal depth.
  void resolve(const FragmentArrays& fragments, const std::vector<Shade>& shades, std::uint32_t* indices,
               std::size_t count, PixelSum& pixel) const;

 private:
  SurfaceModel model_;
};

}  // namespace swept
