#include "splat/pixel_target.h"

#include <cstring>
#include <string>

#include "splat/without_throwing.h"

namespace swept {

Status copy_pixels(const Image& image, const PixelTarget& target) noexcept {
  return without_throwing("for the pixels", [&]() -> Status {
    if (Status status = image.validate(); !status) return status;
    if (target.data == nullptr) return Error{"", "data", "is nowhere"};
    if (target.channels != 3 && target.channels != 4) return Error{"", "channels", "must be 3 or 4"};
    if (target.width != image.width || target.height != image.height)
      return Error{"", "width, height",
                   "are " + std::to_string(target.width) + " x " + std::to_string(target.height) +
                       ", and those of the image are " + std::to_string(image.width) + " x " +
                       std::to_string(image.height)};
    const std::size_t bytes = static_cast<std::size_t>(target.channels) * sizeof(float);
    const std::ptrdiff_t pixel =
        target.pixel_stride_bytes != 0 ? target.pixel_stride_bytes : static_cast<std::ptrdiff_t>(bytes);
    const std::ptrdiff_t row = target.row_stride_bytes != 0 ? target.row_stride_bytes : pixel * image.width;
    const float* from = image.rgba.data();
    for (int y = 0; y < image.height; ++y) {
      char* to = reinterpret_cast<char*>(target.data) + y * row;
      for (int x = 0; x < image.width; ++x, from += 4, to += pixel) std::memcpy(to, from, bytes);
    }
    return Done{};
  });
}

}  // namespace swept
