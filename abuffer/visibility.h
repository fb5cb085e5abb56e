// Which triangle is seen where and when: by the exact method's intervals, and plainly, by rays at instants.
// Source: visibility accuracy is the measure of Gribel et al. 2013, section 6.2.
#pragma once

#include <cstdint>
#include <vector>

#include "abuffer/abuffer.h"
#include "splat/export.h"
#include "splat/render_control.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// The index of a triangle where none is seen.
inline constexpr std::uint32_t no_triangle = 0xffffffffu;

/// The nearest triangle at each of the 16 places of every pixel of the film's window, at each of `times`
/// times.
struct VisibleTriangles {
  int width = 0, height = 0;
  std::size_t times = 0;
  /// width · height · 16 · times indices, by row, pixel, place and time, into the triangles of all objects,
  /// in their order; or no_triangle.
  std::vector<std::uint32_t> triangle;
};

/// What the intervals of the exact method name. `times` are shutter times in [0, 1), increasing; 0 is where
/// the shutter opens. Errors: a scene with anything but triangles, a lens, row delays, overscan, times out of
/// range, and those of render_abuffer().
[[nodiscard]] Result<VisibleTriangles> visible_by_intervals(const Scene& scene,
                                                            const std::vector<double>& times,
                                                            const AbufferOptions& options = {},
                                                            const RenderControl& control = {});
/// What rays meet first of all triangles at these times, with the triangles placed by their true paths.
/// Shares nothing with the exact method. Times and errors: as above.
[[nodiscard]] Result<VisibleTriangles> visible_at_instants(const Scene& scene,
                                                           const std::vector<double>& times,
                                                           const RenderControl& control = {});

struct VisibilityAccuracy {
  std::uint64_t samples = 0;  ///< samples (x, y, t) at which either sees a triangle
  std::uint64_t same = 0;     ///< those of them at which both see the same one
  [[nodiscard]] double share() const {
    return samples > 0 ? static_cast<double>(same) / static_cast<double>(samples) : 1.0;
  }
};
/// Precondition: both have the same size and times. Samples at which neither sees anything are not counted:
/// they would flatter.
[[nodiscard]] VisibilityAccuracy visibility_accuracy(const VisibleTriangles& a, const VisibleTriangles& b);

}  // namespace swept
