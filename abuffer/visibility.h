// Which triangle is seen where and when: by the exact method's intervals, and at instants, the plain way.
// Source: Gribel et al. 2013, section 6.2, whose measure visibility accuracy is.
#pragma once

#include <cstdint>
#include <vector>

#include "abuffer/abuffer.h"
#include "splat/export.h"
#include "splat/render_control.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// Where nothing is seen.
inline constexpr std::uint32_t no_triangle = 0xffffffffu;

/// The nearest triangle at each of the 16 places of every pixel of the film's window, at each of some times.
struct VisibleTriangles {
  int width = 0, height = 0;
  std::size_t times = 0;
  /// By row, pixel, place and time; counted over the triangles of all objects, in their order.
  std::vector<std::uint32_t> triangle;
};

/// Times are by the shutter, in [0, 1), and rise; 0 is where it opens. Errors: a scene that is not of
/// triangles alone, row delays, overscan, times out of range, and those of render_abuffer().
[[nodiscard]] Result<VisibleTriangles> visible_by_intervals(const Scene& scene,
                                                            const std::vector<double>& times,
                                                            const AbufferOptions& options = {},
                                                            const RenderControl& control = {});
/// What rays meet first at these instants, of all triangles, placed by their true paths. Shares nothing with
/// the exact method.
[[nodiscard]] Result<VisibleTriangles> visible_at_instants(const Scene& scene,
                                                           const std::vector<double>& times,
                                                           const RenderControl& control = {});

struct VisibilityAccuracy {
  std::uint64_t samples = 0;  ///< in (x, y, t), in which either sees a triangle
  std::uint64_t same = 0;     ///< of these, the same one
  [[nodiscard]] double share() const {
    return samples > 0 ? static_cast<double>(same) / static_cast<double>(samples) : 1.0;
  }
};
/// Of equal sizes and times. Samples in which neither sees anything are not counted: they would flatter.
[[nodiscard]] VisibilityAccuracy visibility_accuracy(const VisibleTriangles& a, const VisibleTriangles& b);

}  // namespace swept
