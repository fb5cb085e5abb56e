// Stochastic ray casting of the moving discs: how a path tracer would blur them. What the exact renderer is
// compared with in the study, through Embree 3, where that was found at build.
#pragma once

#include <cstdint>

#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// Where within its stratum of the shutter each of a pixel's rays is. Offsets are independent from pixel to
/// pixel either way. `knot` at 256×256 with 4, 16, 64 and 256 rays comes to 28.4, 45.9, 59.9 and 72.0 dB of
/// the exact image with shared offsets, and to 27.5, 40.2, 56.8 and 74.0 dB with independent ones.
enum class Offsets {
  shared,       ///< the same for all: evenly spaced instants (Ramamoorthi et al. 2012, uniform jitter)
  independent,  ///< for each its own (plain jitter)
};

struct RaycastOptions {
  int samples = 16;        ///< n, rays per pixel; [1, 2²⁰]
  int threads = 0;         ///< [0, 1024]; 0: as many as the machine has. Changes no bit
  std::uint64_t seed = 1;  ///< of the instants' offsets
  Offsets offsets = Offsets::shared;

  [[nodiscard]] Status validate() const {
    if (samples < 1 || samples > 1 << 20) return Error{"", "samples", "must be in [1, 1048576]"};
    if (threads < 0 || threads > 1024) return Error{"", "threads", "must be in [0, 1024]"};
    return Done{};
  }
};

/// Whether this build can cast rays.
[[nodiscard]] bool raycast_available();

/// Casts n rays through every pixel's centre (the pixel filter is in the kernels), one at an instant of each
/// of n equal strata of the shutter, without bias.
///
/// What a ray meets of build_kernels() is shaded as a still image is: the image converges to that of
/// render_abuffer(). One ray where the shutter is closed or nothing moves. A crop equals those pixels of the
/// whole frame.
///
/// Statistics: "samples" n or 1, "rays", "hits" collected, "motion_ranges" distinct stretches of time that
/// segments cover; stages "kernels", "build" and "trace".
///
/// Errors: options or scene out of range, not enough memory, discs farther than 10¹⁸ units, which Embree
/// does not see, and a build without Embree.
[[nodiscard]] Result<Rendered> render_raycast(const Scene& scene, const RaycastOptions& options = {});

}  // namespace swept
