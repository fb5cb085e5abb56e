// What every renderer returns.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "splat/camera.h"
#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// One more number for every pixel of an image, row by row as in Image.
struct ImageChannel {
  std::string name;  ///< as in a file: "error", "normal.x"
  std::vector<float> values;
};

/// A window of the film: linear, premultiplied RGBA and depth, rows top to bottom.
struct Image {
  int x = 0, y = 0, width = 0, height = 0;  ///< window within the film, px
  int film_width = 0, film_height = 0;
  std::vector<float> rgba;  ///< 4 per pixel
  /// Camera-space z, 1 per pixel: the mean over exposure and surfaces, weighted by what each adds to alpha.
  /// +∞ where nothing is seen.
  std::vector<float> depth;
  std::vector<ImageChannel> channels = {};  ///< besides R, G, B, A and Z

  [[nodiscard]] std::size_t pixel_count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }

  /// Window and film hold at least a pixel, the arrays fit the window (depth may be empty), and all channels
  /// have different names. Pixel values may be anything. The error's field names the member.
  [[nodiscard]] Status validate() const;
};

/// The film's window, with arrays of its size: transparent black, depth 0.
[[nodiscard]] Image blank_image(const Film& film);

}  // namespace swept
