// Surfaces over surfaces: what the still path and the sweep share.
#pragma once

#include <cstddef>
#include <limits>

#include "splat/export.h"
#include "splat/interval/depth_sum.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// Over which time a pixel's colour is divided by its weights (model section 1.3).
enum class Normalisation {
  /// Over every visible interval by itself, with the alpha that the colour has there: the model's image.
  interval,
  /// Over the whole exposure at once, as Heinzle et al. 2010 do, here for all visible surfaces without the
  /// hidden fragments: rgb = A · Σ T Σₖ wₖ∫ρₖ / Σ T Σₖ oₖ∫ρₖ, with A the pixel's alpha, T the light left in
  /// front of a surface, wₖ and oₖ a kernel's premultiplied colour and opacity. Alpha and depth are those of
  /// `interval`, and so is the colour where a single surface is seen that does not change.
  pixel,
};

/// What a pixel has gathered: premultiplied RGBA, and depth weighted by alpha.
struct PixelSum {
  double rgba[4] = {0.0, 0.0, 0.0, 0.0};
  double depth = 0.0;
  /// Only for Normalisation::pixel: what finish() divides the colours of rgba by.
  double opacity = 0.0;
  DepthSum* by_depth = nullptr;  ///< or null; gathers by depth what is added; for Normalisation::interval
};

/// The depths of a surface, camera-space units, where a piece of time begins and where it ends.
struct DepthSpan {
  double from, to;
};

/// The sums over the fragments of one surface, each fragment weighted by its ρ, or its mean over an interval.
struct SurfaceSum {
  float weight = 0.0f;                       ///< Σρ
  float rgba[4] = {0.0f, 0.0f, 0.0f, 0.0f};  ///< Σρw
  float depth = 0.0f;                        ///< Σρz
};

/// `mean` + `sign`·`swing`.
[[nodiscard]] inline SurfaceSum at_point(const SurfaceSum& mean, const SurfaceSum& swing, float sign) {
  SurfaceSum sum;
  sum.weight = mean.weight + sign * swing.weight;
  for (int c = 0; c < 4; ++c) sum.rgba[c] = mean.rgba[c] + sign * swing.rgba[c];
  sum.depth = mean.depth + sign * swing.depth;
  return sum;
}

/// Below this share of light left, what lies behind is not looked for: 2⁻²⁴ changes no float.
inline constexpr float opaque_transmittance = 0x1p-24f;

/// Coverage and normalisation of a surface (model sections 1.3 and 1.4).
class SurfaceModel {
 public:
  explicit SurfaceModel(const ImageModel& model, Normalisation normalisation = Normalisation::interval)
      : hard_(model.coverage == Coverage::hard),
        per_pixel_(normalisation == Normalisation::pixel),
        edge_weight_(static_cast<float>(model.edge_weight)),
        delta_(static_cast<float>(model.delta)) {}

  [[nodiscard]] bool hard() const { return hard_; }
  [[nodiscard]] bool per_pixel() const { return per_pixel_; }
  [[nodiscard]] float edge_weight() const { return edge_weight_; }
  [[nodiscard]] float delta() const { return delta_; }

  /// What the sums are multiplied by to give coverage times colour: min(1, Σρ/ρ_edge)/Σρ, or 1/Σρ.
  [[nodiscard]] float scale(const SurfaceSum& surface) const {
    // Weights below the normal numbers weigh nothing: their inverse is out of range.
    if (!(surface.weight >= std::numeric_limits<float>::min())) return 0.0f;
    return 1.0f / (hard_ || surface.weight >= edge_weight_ ? surface.weight : edge_weight_);
  }

  /// Puts `surface` behind what the pixel has, for a share `duration` of the shutter. `transmittance` is the
  /// light that is left, in [0, 1]; it is updated. `span` are the depths of the surface for pixel.by_depth;
  /// without it the surface is at its mean depth.
  void add(const SurfaceSum& surface, double duration, float& transmittance, PixelSum& pixel,
           const DepthSpan* span = nullptr) const {
    const float factor = scale(surface);
    if (factor == 0.0f) return;
    const float alpha = surface.rgba[3] * factor < 1.0f ? surface.rgba[3] * factor : 1.0f;
    const double share = static_cast<double>(transmittance) * duration;
    const float of_color = per_pixel_ ? 1.0f : factor;
    for (int c = 0; c < 3; ++c) pixel.rgba[c] += share * static_cast<double>(surface.rgba[c] * of_color);
    pixel.rgba[3] += share * static_cast<double>(alpha);
    if (per_pixel_) pixel.opacity += share * static_cast<double>(surface.rgba[3]);
    pixel.depth += share * static_cast<double>(alpha) * static_cast<double>(surface.depth / surface.weight);
    if (pixel.by_depth != nullptr) [[unlikely]] {
      const double mean = static_cast<double>(surface.depth / surface.weight);
      double rgba[4] = {0.0, 0.0, 0.0, share * static_cast<double>(alpha)};
      for (int c = 0; c < 3; ++c) rgba[c] = share * static_cast<double>(surface.rgba[c] * factor);
      pixel.by_depth->add(span ? span->from : mean, span ? span->to : mean, rgba);
    }
    transmittance *= 1.0f - alpha;
  }

  /// After a pixel's last surface.
  void finish(PixelSum& pixel) const {
    if (!per_pixel_ || !(pixel.opacity > 0.0)) return;
    for (int c = 0; c < 3; ++c) pixel.rgba[c] *= pixel.rgba[3] / pixel.opacity;
    pixel.opacity = 0.0;
  }

 private:
  bool hard_, per_pixel_;
  float edge_weight_, delta_;
};

}  // namespace swept
