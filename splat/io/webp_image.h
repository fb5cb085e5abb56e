// Lossless WebP as a table of bytes. Private to splat/io.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "splat/result.h"

namespace swept::io {

struct ByteImage {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  ///< row by row from the top

  [[nodiscard]] std::size_t pixels() const { return width * height; }
  /// Of pixel i, counted row by row.
  [[nodiscard]] const std::uint8_t* at(std::size_t i) const { return rgba.data() + 4 * i; }
};

/// Errors, without file and field: not WebP, lossy or animated, fewer than `least` or more than `most`
/// pixels, damaged.
[[nodiscard]] Result<ByteImage> read_webp(std::string_view bytes, std::size_t least, std::size_t most);

}  // namespace swept::io
