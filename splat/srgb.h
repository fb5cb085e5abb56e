// The sRGB transfer curve, both ways. For the project's own sources.
#pragma once

#include <cmath>
#include <cstdint>

namespace swept {

/// IEC 61966-2-1, carried on above 1.
[[nodiscard]] inline double srgb_to_linear(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// From linear [0, 1].
[[nodiscard]] inline float linear_to_srgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

/// Into [0, 1]. NaN is 0: fmax returns the number of the two.
[[nodiscard]] inline float clip_to_unit(float value) { return std::fmin(std::fmax(value, 0.0f), 1.0f); }

[[nodiscard]] inline std::uint8_t byte_of(float unit) {
  return static_cast<std::uint8_t>(std::lround(255.0f * unit));
}

/// A linear value as 8 bits of sRGB, clipped.
[[nodiscard]] inline std::uint8_t srgb_byte(float linear) {
  return byte_of(linear_to_srgb(clip_to_unit(linear)));
}

}  // namespace swept
