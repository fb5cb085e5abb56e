// Pictures for textures.
#pragma once

#include <string>

#include "splat/export.h"
#include "splat/result.h"
#include "splat/texture.h"

namespace SWEPT_API swept {

/// Reads a picture by its name's extension. PNG: 8-bit values are sRGB unless the file says otherwise, 16-bit
/// ones linear unless it says so; grey and palettes become colour. EXR: R, G, B and A as read_exr() does,
/// linear and premultiplied. Errors: missing, truncated and corrupt files, other extensions, more than 2²⁸
/// texels, alphas outside [0, 1].
[[nodiscard]] Result<Texture> read_texture(const std::string& path);

}  // namespace swept
