// A texture: a picture that multiplies the colours of triangles.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// Where the corners of a triangle lie on a texture: (u, v), v up.
using TextureCorners = std::array<Eigen::Vector2f, 3>;

/// Texture coordinates beyond ± this are refused: their fractions would not resolve a texel.
inline constexpr float most_texture_coordinate = 1e6f;

/// Texels have their values in their middles, and the texture is linear from middle to middle (model section
/// 15.2).
struct Texture {
  int width = 0, height = 0;            ///< texels
  std::vector<Eigen::Vector4f> texels;  ///< linear Rec.709, premultiplied RGBA; row by row from the top

  /// The value at (u, v): (0, 0) is the lower left corner of the picture and (1, 1) the upper right one.
  /// Beyond these the picture repeats.
  [[nodiscard]] Eigen::Vector4f at(double u, double v) const;

  /// Sizes agree, every number is finite, alpha is in [0, 1]. The error's field is a pointer into the
  /// texture.
  [[nodiscard]] Status validate() const;
};

}  // namespace swept
