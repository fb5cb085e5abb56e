// Shutter time as the A-buffer counts it.
#pragma once

#include <cstdint>

#include "splat/export.h"

namespace SWEPT_API swept {

/// Shutter time in 2⁻³⁰ of the exposure: 0 is open, shutter_close is closed. As fine at the end as at the
/// beginning, where a float's last digit is 2⁻²⁴ of the exposure, which a fast disc needs to pass a pixel;
/// and all differences are exact.
using Ticks = std::int32_t;

inline constexpr Ticks shutter_close = Ticks{1} << 30;
inline constexpr float per_tick = 0x1p-30f;

/// The nearest, for `t_shutter` in [0, 1].
[[nodiscard]] inline Ticks ticks_of(double t_shutter) {
  const auto halves = static_cast<std::int64_t>(t_shutter * (2.0 * shutter_close));
  return static_cast<Ticks>((halves + 1) / 2);
}
/// As a share of the exposure, exactly.
[[nodiscard]] inline double share_of(Ticks ticks) { return ticks * double{per_tick}; }

}  // namespace swept
