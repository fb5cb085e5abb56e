// From a scene to its moving kernels: the one door through which every renderer sees a scene.
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "splat/export.h"
#include "splat/kernel/moving_kernel.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// What a scene's kernels are, counted.
struct KernelCounts {
  std::size_t surfels = 0;           ///< points of all objects
  int most_segments = 1;             ///< of any object
  std::size_t still_kernels = 0;     ///< kernels that do not move
  std::size_t standing_kernels = 0;  ///< of these, those of objects of which nothing moves
  std::size_t edge_on_kernels = 0;   ///< discs within 10⁻³ of being seen edge-on from the eye
  std::size_t near_kernels = 0;      ///< kernels that reach to the near plane and beyond it
  /// Segments whose disc has no area and no thickness on screen, or that are too large for numbers.
  std::size_t culled_degenerate = 0;
  std::size_t culled_near = 0;  ///< wholly nearer than the near plane or behind the eye
};

/// All kernels of one frame, in an order that depends on their content alone: permuting a scene's points
/// or objects changes nothing.
struct KernelSet : KernelCounts {
  std::vector<MovingKernel> kernels;
  Projection
      projection;     ///< of the film, at the middle of the shutter; a changing zoom is part of the motion
  double near = 0.0;  ///< camera-space depth, > 0
};

/// Cuts every surfel's path through camera space over the exposure into linear_segments(), or, where
/// cuts_by_point() says so, each by itself (splat/motion/cut.h); one where nothing moves. Of points that come
/// or go there is what exists. Where rows are exposed one after the other, segments run over the exposures of
/// all of them, in the shutter time of the top row, so that times may lie outside [0, 1]. A segment has the
/// mean velocity of its stretch of the path and, by Simpson's rule, its mean position: to first order a
/// blurred image sees nothing else of it, and the chord between the path's ends misses the second. Axes,
/// normal and pixel filter are those of its middle. Colours and opacities that change do so evenly within it.
/// `scene` must satisfy validate(). Once `stop` asks for it, what is there by then is returned, in any order.
[[nodiscard]] KernelSet build_kernels(const Scene& scene, const Exposure& exposure,
                                      const std::stop_token& stop = {});
/// The same over the scene's own exposure.
[[nodiscard]] inline KernelSet build_kernels(const Scene& scene) {
  return build_kernels(scene, scene.exposure());
}

}  // namespace swept
