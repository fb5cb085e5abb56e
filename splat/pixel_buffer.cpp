#include "splat/pixel_buffer.h"

#include <cstring>
#include <string>

#include "splat/without_throwing.h"

namespace swept {

Status copy_pixels(const Image& image, const PixelBuffer& buffer) noexcept {
  return without_throwing("for the pixels", [&]() -> Status {
    if (Status status = image.validate(); !status) return status;
    if (buffer.data == nullptr) return Error{"", "data", "is nowhere"};
    if (buffer.channels != 3 && buffer.channels != 4) return Error{"", "channels", "must be 3 or 4"};
    if (buffer.width != image.width || buffer.height != image.height)
      return Error{"", "width, height",
                   "are " + std::to_string(buffer.width) + " x " + std::to_string(buffer.height) +
                       ", and those of the image are " + std::to_string(image.width) + " x " +
                       std::to_string(image.height)};
    const std::size_t bytes = static_cast<std::size_t>(buffer.channels) * sizeof(float);
    const std::ptrdiff_t pixel =
        buffer.pixel_stride_bytes != 0 ? buffer.pixel_stride_bytes : static_cast<std::ptrdiff_t>(bytes);
    const std::ptrdiff_t row = buffer.row_stride_bytes != 0 ? buffer.row_stride_bytes : pixel * image.width;
    const float* from = image.rgba.data();
    for (int y = 0; y < image.height; ++y) {
      char* to = reinterpret_cast<char*>(buffer.data) + y * row;
      for (int x = 0; x < image.width; ++x, from += 4, to += pixel) std::memcpy(to, from, bytes);
    }
    return Done{};
  });
}

}  // namespace swept
