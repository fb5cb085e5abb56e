// The sRGB transfer curve undone. For the project's own sources.
#pragma once

#include <cmath>

namespace swept {

/// IEC 61966-2-1, carried on above 1.
[[nodiscard]] inline double srgb_to_linear(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

}  // namespace swept
