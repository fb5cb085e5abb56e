// Surfaces over surfaces: what the still path and the sweep share.
#pragma once

#include <cstddef>

#include "splat/scene.h"

namespace swept {

/// What a pixel has gathered: premultiplied RGBA, and depth weighted by alpha.
struct PixelSum {
  double rgba[4] = {0.0, 0.0, 0.0, 0.0};
  double depth = 0.0;
};

/// The sums over the fragments of one surface, each fragment weighted by its ρ, or its mean over an interval.
struct SurfaceSum {
  float weight = 0.0f;                       ///< Σρ
  float rgba[4] = {0.0f, 0.0f, 0.0f, 0.0f};  ///< Σρw
  float depth = 0.0f;                        ///< Σρz
};

/// Coverage and normalisation of a surface (model sections 1.3 and 1.4).
class SurfaceModel {
 public:
  explicit SurfaceModel(const ImageModel& model)
      : hard_(model.coverage == Coverage::hard), edge_weight_(static_cast<float>(model.edge_weight)) {}

  [[nodiscard]] bool hard() const { return hard_; }
  [[nodiscard]] float edge_weight() const { return edge_weight_; }

  /// What the sums are multiplied by to give coverage times colour: min(1, Σρ/ρ_edge)/Σρ, or 1/Σρ.
  [[nodiscard]] float scale(const SurfaceSum& surface) const {
    if (!(surface.weight > 0.0f)) return 0.0f;
    return 1.0f / (hard_ || surface.weight >= edge_weight_ ? surface.weight : edge_weight_);
  }

 private:
  bool hard_;
  float edge_weight_;
};

/// Below this share of light left, what lies behind is not looked for: 2⁻²⁴ changes no float.
inline constexpr float opaque_transmittance = 0x1p-24f;

/// Puts `surface` behind what the pixel has, for a share `duration` of the shutter. `transmittance` is what
/// is left of the light, before and after.
inline void add_surface(const SurfaceSum& surface, float scale, float duration, float& transmittance,
                        PixelSum& pixel) {
  if (scale == 0.0f) return;
  const float alpha = surface.rgba[3] * scale < 1.0f ? surface.rgba[3] * scale : 1.0f;
  const double share = static_cast<double>(transmittance) * static_cast<double>(duration);
  for (int c = 0; c < 4; ++c) pixel.rgba[c] += share * static_cast<double>(surface.rgba[c] * scale);
  pixel.depth += share * static_cast<double>(alpha) * static_cast<double>(surface.depth / surface.weight);
  transmittance *= 1.0f - alpha;
}

}  // namespace swept
