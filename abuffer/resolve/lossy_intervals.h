// At most so many intervals of time a place of a pixel, those merged first that cost the least. Source:
// Gribel et al. 2010, Analytical Motion Blur Rasterization with Compression, section 4, whose oracle ours
// stands in for: what hides what is known, so that hidden intervals go first and cost nothing.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "abuffer/sources/triangle_stretch.h"

namespace swept {

/// A thread's.
class LossyIntervals {
 public:
  /// `most` of a place; 0: all, and nothing below changes anything.
  explicit LossyIntervals(std::size_t most) : most_(most) {}
  [[nodiscard]] std::size_t most() const { return most_; }

  /// Of the intervals of one place, in the order in which triangles are met, leaves fewer than twice `most`
  /// in front and returns how many. What is left in the end does not depend on how often it was called
  /// between.
  [[nodiscard]] std::size_t shorten(std::span<PlaceInterval> intervals,
                                    const std::vector<TriangleStretch>& triangles);
  /// Leaves `most`, after the last one was met.
  [[nodiscard]] std::size_t finish(std::span<PlaceInterval> intervals,
                                   const std::vector<TriangleStretch>& triangles);

 private:
  void merge_to_most(const std::vector<TriangleStretch>& triangles);

  std::size_t most_;
  std::vector<PlaceInterval> held_;
};

}  // namespace swept
