// Shutter time as the A-buffer counts it.
#pragma once

#include <cstdint>

#include "splat/export.h"

namespace SWEPT_API swept {

/// Shutter time in units of 2⁻³⁰ of the exposure: 0 is open, shutter_close is closed. Ticks are as fine at
/// the end of the exposure as at its beginning, and all differences are exact. A float would resolve only
/// 2⁻²⁴ at the end, which is as long as a fast disc needs to pass a pixel.
using Ticks = std::int32_t;

inline constexpr Ticks shutter_close = Ticks{1} << 30;
inline constexpr float per_tick = 0x1p-30f;

/// The nearest tick to `t_shutter` in [0, 1].
[[nodiscard]] inline Ticks ticks_of(double t_shutter) {
  const auto halves = static_cast<std::int64_t>(t_shutter * (2.0 * shutter_close));
  return static_cast<Ticks>((halves + 1) / 2);
}
/// As a share of the exposure, exactly.
[[nodiscard]] inline double share_of(Ticks ticks) { return ticks * double{per_tick}; }

}  // namespace swept
