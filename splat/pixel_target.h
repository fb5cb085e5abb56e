// Copies an image into memory of the caller: a texture, a frame of a viewer, a part of a larger picture.
#pragma once

#include <cstddef>

#include "splat/export.h"
#include "splat/image.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// Rows of pixels of floats, red first. Strides may be negative: a picture stored from the bottom up begins
/// at its last row.
struct PixelTarget {
  float* data = nullptr;  ///< red of the upper left pixel
  int width = 0, height = 0;
  int channels = 4;                       ///< 3: red, green, blue; 4: alpha, too
  std::ptrdiff_t pixel_stride_bytes = 0;  ///< 0: pixels are packed
  std::ptrdiff_t row_stride_bytes = 0;    ///< 0: rows are packed
};

/// Writes the pixels of the image's window, linear and premultiplied, and no other bytes of the target.
/// Errors: sizes that differ, channels other than 3 or 4, no memory given. After an error nothing was
/// written.
[[nodiscard]] Status copy_pixels(const Image& image, const PixelTarget& target) noexcept;

}  // namespace swept
