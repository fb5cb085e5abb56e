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

/// Which triangles of one-sided meshes are left out because their backs are seen.
enum class BackFaces {
  exact,      ///< at each instant, those that show their backs then
  both_ends,  ///< in addition, for the whole exposure, those that show their backs when it begins and when it
              ///< ends (Rönnow et al. 2021, section 4.4), though they may show their fronts in between
};

/// `normalisation`, `place_intervals` and `back_faces` change the image; `tile_tests` changes last digits
/// where several meshes share a pixel. The other options change no bit.
struct AbufferOptions {
  int tile_px = 32;  ///< side of a tile; [1, 4096]
  std::size_t tile_fragments =
      1u << 20;      ///< fragments one thread may hold; a fuller tile is done in parts. > 0
  bool simd = true;  ///< false: the plain loops that define what vectors compute
  Normalisation normalisation = Normalisation::interval;  ///< changes the image
  /// For meshes: intervals of time that are kept at each of a pixel's 16 places, [0, 65536]. If there are
  /// more, those whose merging errs least are merged (Gribel et al. 2010), in an order that depends on that
  /// of the meshes. 0: all are kept.
  std::size_t place_intervals = 0;
  BackFaces back_faces = BackFaces::exact;  ///< for one-sided meshes; `both_ends` is another image
  /// For meshes: leave out pixels, tiles and depths in which a triangle is known not to be seen, before its
  /// intervals are solved. false: keep them, to measure what the tests gain.
  bool tile_tests = true;
  /// Segments of paths may be parabolas, and their axes may follow the disc. false: all segments are chords,
  /// those of build_kernels(), which are more and no nearer to the true path.
  bool parabolas = true;
  bool deep = false;  ///< also fill Rendered::deep; only with Normalisation::interval

  [[nodiscard]] Status validate() const;
};

/// Renders the scene's film window. The result is the same, bit for bit, for any thread count, tile size and
/// order of the scene's points, and a crop equals those pixels of the whole frame.
///
/// A lens takes a copy of the scene, and a sweep for each of its points.
///
/// Triangles are swept place by place (model section 15), and discs among them by their depth. Bins hold all
/// triangles in all pieces of their paths. `simd` has no effect on triangles.
///
/// control.max_bytes bounds each of these by itself: what is kept of moving points and triangles, what is
/// kept of what stands still, and the samples by depth. tile_fragments bounds the fragments, and likewise the
/// intervals of triangles, that a thread holds.
///
/// Errors: options, control or scene out of range; splats, which are refused by name; options for meshes
/// where the scene has no such mesh; triangles together with Normalisation::pixel; a row delay together with
/// a shutter curve or with a given number of segments; not enough memory; a render that was stopped.
[[nodiscard]] Result<Rendered> render_abuffer(const Scene& scene, const AbufferOptions& options = {},
                                              const RenderControl& control = {});

}  // namespace swept
