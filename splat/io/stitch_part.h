// One of the crops that are put together. For splat/io's own sources.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfPixelType.h>

#include "splat/io/image_file.h"
#include "splat/result.h"

namespace swept::io {

struct StitchPart {
  std::string path;
  Image window;  ///< without pixels
  ExrOrigin origin;
  std::string whole;
  bool deep = false;
};

[[nodiscard]] inline std::size_t bytes_of(Imf::PixelType type) { return type == Imf::HALF ? 2 : 4; }

[[nodiscard]] inline Error parts_differ(const StitchPart& part, const std::string& channel, int x, int y) {
  return {part.path, channel,
          "differs from another part at pixel " + std::to_string(x) + ", " + std::to_string(y)};
}

/// Writes the deep scan lines of `parts`, which cover the film of `header`, one line after the other: memory
/// holds those of one line. Throws what OpenEXR does.
[[nodiscard]] Status stitch_deep(const std::vector<StitchPart>& parts, const Imf::Header& header,
                                 Imf::OStream& stream);

}  // namespace swept::io
