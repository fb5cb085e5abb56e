// The exact renderer: every fragment of every pixel, resolved over the whole exposure.
#pragma once

#include <cstddef>

#include "splat/export.h"
#include "splat/interval/composite.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// None of these changes a bit of the image but `normalisation` and `place_intervals`, and `tile_tests` last
/// digits where several meshes share a pixel.
struct AbufferOptions {
  int tile_px = 32;  ///< side of a tile; [1, 4096]
  std::size_t tile_fragments =
      1u << 20;      ///< fragments one thread may hold; a fuller tile is done in parts. > 0
  bool simd = true;  ///< false: the plain loops that define what vectors compute
  Normalisation normalisation = Normalisation::interval;  ///< changes the image
  /// Intervals of time that are kept of triangles at each of a pixel's 16 places, [1, 65536]: more are merged
  /// by least error (Gribel et al. 2010), in an order that depends on that of the meshes. 0: all. With
  /// meshes.
  std::size_t place_intervals = 0;
  /// With meshes: leave out pixels, tiles and depths that triangles are known not to be seen in, before their
  /// intervals are solved. false: not, to measure what it gains.
  bool tile_tests = true;
  /// Discs that are small beside their way may have parabolas for segments. false: chords, those of
  /// build_kernels(), which are more, and no nearer to the true path.
  bool parabolas = true;
  bool deep = false;  ///< fill Rendered::deep, too; with Normalisation::interval alone

  [[nodiscard]] Status validate() const;
};

/// Renders the scene's film window. The result is the same, bit for bit, for any thread count, tile size and
/// order of the scene's points, and a crop equals those pixels of the whole frame.
///
/// A lens takes a copy of the scene, and a sweep for each of its points.
///
/// Triangles are swept place by place (model section 15), over bins of all of them in all stretches of their
/// paths, and discs among them by their depth. tile_fragments bounds what a thread holds of intervals, too;
/// `simd` changes nothing of them.
///
/// Errors: options, control or scene out of range, triangles together with Normalisation::pixel, not enough
/// memory, and a render that was stopped. control.max_bytes bounds what is kept of moving points and
/// triangles, what stands still, and samples by depth, each by itself; tile_fragments bounds what a thread
/// holds of fragments.
[[nodiscard]] Result<Rendered> render_abuffer(const Scene& scene, const AbufferOptions& options = {},
                                              const RenderControl& control = {});

}  // namespace swept
