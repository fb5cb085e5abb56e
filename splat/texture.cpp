#include "splat/texture.h"

#include <cmath>
#include <cstddef>
#include <string>

#include "splat/surfel.h"

namespace swept {
namespace {

/// Two neighbours of a row or column of `count` texels that repeats, and the second one's share.
struct Between {
  std::size_t first, second;
  float share;
};

Between between(double texels, int count) {
  const double low = std::floor(texels), turns = std::floor(low / count);
  auto first = static_cast<std::size_t>(low - turns * count);
  // Rounding may have it at the end of the turn.
  if (first >= static_cast<std::size_t>(count)) first = 0;
  const std::size_t second = first + 1 < static_cast<std::size_t>(count) ? first + 1 : 0;
  return {first, second, static_cast<float>(texels - low)};
}

}  // namespace

Eigen::Vector4f Texture::at(double u, double v) const {
  const Between x = between(u * width - 0.5, width), y = between((1.0 - v) * height - 0.5, height);
  const auto row = [&](std::size_t of) -> Eigen::Vector4f {
    const Eigen::Vector4f* texel = &texels[of * static_cast<std::size_t>(width)];
    return texel[x.first] + x.share * (texel[x.second] - texel[x.first]);
  };
  const Eigen::Vector4f first = row(y.first);
  return first + y.share * (row(y.second) - first);
}

Status Texture::validate() const {
  if (width < 1 || height < 1 ||
      texels.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return Error{
        "", "/texels",
        std::to_string(texels.size()) + " are not " + std::to_string(width) + " x " + std::to_string(height)};
  for (std::size_t i = 0; i < texels.size(); ++i) {
    // Written so that NaN fails it.
    if (!(texels[i].cwiseAbs().maxCoeff() <= most_color) || !texels[i].allFinite())
      return Error{"", "/texels/" + std::to_string(i), "must be between -1e30 and 1e30"};
    if (texels[i].w() < 0.0f || texels[i].w() > 1.0f)
      return Error{"", "/texels/" + std::to_string(i), "alpha must be between 0 and 1"};
  }
  return Done{};
}

}  // namespace swept
