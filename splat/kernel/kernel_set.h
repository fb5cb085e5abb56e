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

/// Counts of a scene's kernels.
struct KernelCounts {
  std::size_t surfels = 0;           ///< points of all objects
  int most_segments = 1;             ///< of any object
  std::size_t still_kernels = 0;     ///< kernels that do not move
  std::size_t standing_kernels = 0;  ///< of these, those of objects of which nothing moves
  std::size_t edge_on_kernels = 0;   ///< discs within 10⁻³ of being seen edge-on from the eye
  std::size_t near_kernels = 0;      ///< kernels that cross the near plane
  /// Segments that are left out because their disc has neither area nor thickness on the film, or numbers
  /// beyond range.
  std::size_t culled_degenerate = 0;
  std::size_t culled_near = 0;  ///< segments left out because they are nearer than the near plane throughout
};

/// All kernels of one frame, in an order that depends only on their content: permuting a scene's points or
/// objects changes nothing.
struct KernelSet : KernelCounts {
  std::vector<MovingKernel> kernels;
  /// Of the film at the middle of the shutter; a zoom that changes is part of the kernels' motion.
  Projection projection;
  double near = 0.0;  ///< camera-space depth, > 0
};

/// Cuts every surfel's path through camera space over the exposure into linear segments: linear_segments() of
/// them, or, where cuts_by_point() says so, each path by itself (splat/motion/cut.h); a single one if nothing
/// moves. Points that come or go have kernels only for the time in which they exist.
///
/// A segment has the mean velocity of its piece of the path and, by Simpson's rule, its mean position. To
/// first order a blurred image depends on nothing else; the chord between the ends of the piece would have
/// another mean position. Axes, normal and pixel filter are those of the segment's middle. Colours and
/// opacities that change are linear within it. If rows are exposed one after the other, segments run over the
/// exposures of all rows, in the shutter time of the top row, so that times may lie outside [0, 1].
///
/// Precondition: scene.validate(). After a request to `stop`, the kernels made so far are returned, in any
/// order.
[[nodiscard]] KernelSet build_kernels(const Scene& scene, const Exposure& exposure,
                                      const std::stop_token& stop = {});
/// build_kernels() over the scene's own exposure.
[[nodiscard]] inline KernelSet build_kernels(const Scene& scene) {
  return build_kernels(scene, scene.exposure());
}

}  // namespace swept
