// The exact renderer: every fragment of every pixel, resolved over the whole exposure.
#pragma once

#include <cstddef>

#include "splat/interval/composite.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

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
