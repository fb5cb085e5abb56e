#include "splat/io/webp_image.h"

#include <algorithm>
#include <string>

#include <webp/decode.h>

namespace swept::io {

Result<ByteImage> read_webp(std::string_view bytes, std::size_t least, std::size_t most) {
  const auto* const data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK)
    return Error{"", "", "is no WebP image"};
  constexpr int lossless = 2;
  if (features.has_animation || features.format != lossless)
    return Error{"", "", "is no lossless still of WebP, so its numbers are not those that were written",
                 ErrorKind::unsupported};
  ByteImage image;
  image.width = static_cast<std::size_t>(features.width);
  image.height = static_cast<std::size_t>(features.height);
  if (image.pixels() < least || image.pixels() > most)
    return Error{"", "",
                 "has " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                     " pixels, not " + std::to_string(least) +
                     (most > least ? " to " + std::to_string(most) : "")};
  image.rgba.resize(4 * image.pixels());
  const int stride = static_cast<int>(4 * image.width);  // at most 16383 pixels
  if (!WebPDecodeRGBAInto(data, bytes.size(), image.rgba.data(), image.rgba.size(), stride))
    return Error{"", "", "is damaged"};
  return image;
}

}  // namespace swept::io
