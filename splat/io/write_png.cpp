#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <png.h>

#include "splat/io/atomic_file.h"
#include "splat/io/guarded.h"
#include "splat/io/image_file.h"

namespace swept {
namespace {

/// The sRGB transfer of IEC 61966-2-1 from linear [0, 1].
float srgb_of_linear(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

/// NaN is 0: fmax returns the number of the two.
float clip(float value) { return std::fmin(std::fmax(value, 0.0f), 1.0f); }

std::uint8_t byte_of(float unit) { return static_cast<std::uint8_t>(std::lround(255.0f * unit)); }

std::vector<std::uint8_t> bytes_of(const Image& image) {
  std::vector<std::uint8_t> bytes(image.rgba.size());
  for (std::size_t pixel = 0; pixel < image.pixel_count(); ++pixel) {
    const float* rgba = &image.rgba[4 * pixel];
    const float alpha = clip(rgba[3]);
    if (alpha == 0.0f) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      bytes[4 * pixel + c] = byte_of(srgb_of_linear(clip(rgba[c] / alpha)));
    }
    bytes[4 * pixel + 3] = byte_of(alpha);
  }
  return bytes;
}

Status write(const std::string& path, const Image& image, IfExists existing) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();

  // libpng's one-call interface: no longjmp past C++ objects, and it adds the sRGB chunk itself.
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGBA;
  const std::vector<std::uint8_t> bytes = bytes_of(image);
  if (png_image_write_to_stdio(&header, file->stream(), 0, bytes.data(), 0, nullptr) == 0) {
    return Error{path, "", std::string("cannot be written: ") + header.message};
  }
  return file->commit(existing);
}

}  // namespace

Status write_png(const std::string& path, const Image& image, IfExists existing) {
  if (const Status status = image.validate(); !status) {
    return Error{path, status.error().field, status.error().reason};
  }
  return io::guarded(path, [&] { return write(path, image, existing); });
}

}  // namespace swept
