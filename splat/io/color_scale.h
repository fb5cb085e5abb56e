// What stored colours stand for: what is full, and whether they are linear. Types and numbers say it, the
// caller says it better.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "splat/io/attributes.h"

namespace swept {

/// (stored − least) / (full − least) is the channel, which `space` relates to light.
struct ColorScale {
  double full = 1.0;   ///< what a full channel is stored as
  double least = 0.0;  ///< what black is stored as
  ColorSpace space = ColorSpace::linear;
  std::string assumed;  ///< in words, for the report

  [[nodiscard]] double channel(double stored) const { return (stored - least) / (full - least); }
  /// Linear light; may be beyond what a float holds.
  [[nodiscard]] double linear(double stored) const;
};

/// Of colours. Integers of 8 bits, and of 32, are taken for 0 to 255, of 16 for 0 to 65535, in sRGB; reals
/// for 0 to 1, linear. Unless the numbers say otherwise: 16-bit ones that never exceed 255 are 8-bit ones;
/// reals and 32-bit integers are 0 to 255, or whole ones 0 to 65535, if more than half of those that are not
/// zero exceed 1 and none exceeds that: light brighter than 1 is rarely so common.
[[nodiscard]] ColorScale color_scale(const std::vector<Column>& columns, const AttributePlan::Triple& color,
                                     const std::vector<std::vector<double>>& values,
                                     const ReadOptions& options);

/// Of intensities, in sRGB: the least of 1 and 2ⁿ − 1, n = 8, 10, 12, 14, 16, that none exceeds, else the
/// greatest; from −2048 to 2047 where there are negative ones (PTS files). None where that does not help.
[[nodiscard]] std::optional<ColorScale> grey_scale(const Column& column, const std::vector<double>& values,
                                                   const ReadOptions& options);

/// Full opacity in a column beside colours of `color_full`.
[[nodiscard]] double alpha_full(const Column& column, const std::vector<double>& values, double color_full);

}  // namespace swept
