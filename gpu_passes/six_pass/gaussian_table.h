// The lookup tables of Heinzle et al. 2010, section 5.3.
#pragma once

#include "gpu_passes/device/gl_object.h"

namespace swept {

/// The tables' arguments end here; √δ is 7.07 at most.
inline constexpr float table_range = 8.0f;
inline constexpr int table_texels = 1024;

/// exp(−y²) and erf(y) in the two channels of a row of texels, the first for y = 0 and the last for
/// table_range; read by gaussian.glsl with linear filtering.
[[nodiscard]] GlTexture make_gaussian_table();

}  // namespace swept
