// One kernel as the passes get it.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

#include "splat/kernel/kernel_set.h"
#include "splat/kernel/screen_bounds.h"

namespace swept {

/// Instance data of footprint.vert, in the order of its attributes; kernel.glsl says what the members are.
/// Affine functions are (value at the anchor, change per px in x, change per px in y).
struct Instance {
  glm::vec4 plane, line_u, line_v, rate_u, rate_v, facing, color, anchor, box_open, box_close;
};
inline constexpr int instance_attributes = 10;
static_assert(sizeof(Instance) == instance_attributes * sizeof(glm::vec4));

/// A rectangle of pixels of the whole film.
struct PixelWindow {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The set-up is in double, and only the finished coefficients become floats. `octagon` is the kernel's
/// screen_bounds(); it is widened by what the GPU's own arithmetic may lose of it.
[[nodiscard]] Instance make_instance(const MovingKernel& kernel, const Octagon& octagon,
                                     const Projection& projection, const PixelWindow& window);

/// Instances of the kernels that reach the window, in the order of the set.
[[nodiscard]] std::vector<Instance> make_instances(const KernelSet& set, const PixelWindow& window);

}  // namespace swept
