// The exact renderer: every fragment of every pixel, resolved over the whole exposure.
#pragma once

#include <cstddef>

#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// Over what a pixel's colour is divided by its weights (model section 1.3).
enum class Normalisation {
  /// Every visible interval by itself, each colour with the alpha that it has there: what the image is.
  interval,
  /// The whole exposure at once, as Heinzle et al. 2010 do, here over all visible surfaces and after hidden
  /// fragments are gone: rgb = A · Σ T Σₖ wₖ∫ρₖ / Σ T Σₖ oₖ∫ρₖ, with A the pixel's alpha, T the light left in
  /// front of a surface, wₖ and oₖ a kernel's premultiplied colour and opacity. Alpha and depth are those of
  /// `interval`, and so is the colour where a single surface is seen that does not change.
  pixel,
};

/// None of these changes a bit of the image but `normalisation`.
struct AbufferOptions {
  int threads = 0;   ///< 0: as many as the machine has
  int tile_px = 32;  ///< side of a tile; [1, 4096]
  std::size_t tile_fragments =
      1u << 20;      ///< fragments one thread may hold; a fuller tile is done in parts. > 0
  bool simd = true;  ///< false: the plain loops that define what vectors compute
  Normalisation normalisation = Normalisation::interval;  ///< the one option that changes the image

  [[nodiscard]] Status validate() const;
};

/// Renders the scene's film window. The result is the same, bit for bit, for any thread count, tile size and
/// order of the scene's points, and a crop equals those pixels of the whole frame.
[[nodiscard]] Result<Rendered> render_abuffer(const Scene& scene, const AbufferOptions& options = {});

}  // namespace swept
