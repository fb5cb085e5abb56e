// At how many points in time a piece of the exposure is looked at.
//
// Between two events the surfaces of a pixel keep their members, but not their colours. Source: model section
// 4, where a ratio of integrals stands for the integral of ratios; here Gauss-Legendre's rule of two points
// does.
#pragma once

#include <algorithm>

namespace swept {

/// What a piece may be off by in the image.
inline constexpr float piece_error = 0x1p-12f;

/// How far a kernel may move along its line, in units of y, in one piece that several kernels share: as far
/// as the sums' series reaches.
inline constexpr float longest_span = 0.5f;
/// The same where their mean and first moment are all that is used of them.
inline constexpr float longest_front_span = 0.8f;

/// Whether two points in time are enough for the integral of a surface's colour over a piece.
///
/// With C the colour, over a span s Gauss's two points differ from the integral by at most s⁴/4320 |C⁽⁴⁾|. ln
/// ρ has slopes of up to 2√δ, and for two kernels, one black and one white, C is a logistic function of up to
/// 4√δ y. `span` is of the fastest kernel, `duration` a share of the exposure, `range` how far colours
/// differ.
[[nodiscard]] inline bool two_points_suffice(float span, float duration, float delta, float range = 1.0f) {
  const float square = delta * span * span;
  return 7.6e-3f * range * duration * square * square <= piece_error;
}

/// The longest piece, as a share of the exposure, over which kernels of that rate keep to the rule and move
/// no farther than `longest` along their lines.
[[nodiscard]] inline float longest_piece(float rate, float longest, float delta, float range = 1.0f) {
  float duration = rate > 0.0f ? std::min(1.0f, 0.99f * longest / rate) : 1.0f;
  while (!two_points_suffice(rate * duration, duration, delta, range)) duration *= 0.9f;
  return duration;
}

}  // namespace swept
