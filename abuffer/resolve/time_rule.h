// At how many points in time a piece of the exposure is looked at.
//
// Between two events the surfaces of a pixel keep their members, but not their colours. Source: model section
// 4, where a ratio of integrals stands for the integral of ratios; where that would show, Gauss-Legendre's
// rules do.
#pragma once

namespace swept {

/// What a piece may be off by in the image.
inline constexpr float piece_error = 0x1p-12f;

/// On [0, 1].
struct GaussRule {
  int points;
  double place[3], weight[3];
};

inline constexpr int most_points = 3;

/// Of three points, or of two.
[[nodiscard]] inline const GaussRule& gauss_rule(int points) {
  static constexpr GaussRule two = {2, {0.21132486540518712, 0.78867513459481288}, {0.5, 0.5}};
  static constexpr GaussRule three = {
      3, {0.11270166537925831, 0.5, 0.88729833462074169}, {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0}};
  return points >= 3 ? three : two;
}

/// At how many points a piece has to be looked at for the integral of a surface's colour: 1 for the ratio of
/// two integrals, 2 or 3 for Gauss's, more for a piece that is too long.
///
/// With C the colour and W = Σρ, over a span s the three differ from the integral of ratios by at most
/// s²/12 |C′W′/W|, s⁴/4320 |C⁽⁴⁾| and s⁶/2016000 |C⁽⁶⁾|. ln ρ has slopes of up to 2√δ. So |C′W′/W| ≤ 0.77 δ,
/// however many kernels there are, and for two, one black and one white, C is a logistic function of up to
/// 4√δ y. Ratios of neighbouring pieces are off to the same side and add up: they get a quarter of the error.
/// `span` is of the fastest kernel, `duration` a share of the exposure.
[[nodiscard]] inline int points_for(float span, float duration, float delta) {
  const float square = delta * span * span;
  if (duration * square <= 4.0f * piece_error) return 1;
  const float fourth = duration * square * square;
  if (7.6e-3f * fourth <= piece_error) return 2;
  return 8.3e-4f * fourth * square <= piece_error ? 3 : most_points + 1;
}

}  // namespace swept
