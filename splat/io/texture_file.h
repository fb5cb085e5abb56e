// Pictures for textures.
#pragma once

#include <string>

#include "splat/export.h"
#include "splat/result.h"
#include "splat/texture.h"

namespace SWEPT_API swept {

/// Reads a picture, by the extension of its name. PNG: 8-bit values are sRGB and 16-bit values linear, unless
/// the file says otherwise; grey and palettes become colour. EXR: R, G, B and A as by read_exr(), linear and
/// premultiplied. Errors: missing, truncated and corrupt files, other extensions, more than 2²⁸ texels,
/// alphas outside [0, 1].
[[nodiscard]] Result<Texture> read_texture(const std::string& path);

}  // namespace swept
