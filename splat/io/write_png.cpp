#include <cstdint>
#include <string>
#include <vector>

#include <png.h>

#include "splat/io/atomic_file.h"
#include "splat/io/guarded.h"
#include "splat/io/image_file.h"
#include "splat/srgb.h"

namespace swept {
namespace {

std::vector<std::uint8_t> bytes_of(const Image& image) {
  std::vector<std::uint8_t> bytes(image.rgba.size());
  for (std::size_t pixel = 0; pixel < image.pixel_count(); ++pixel) {
    const float* rgba = &image.rgba[4 * pixel];
    const float alpha = clip_to_unit(rgba[3]);
    if (alpha == 0.0f) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      bytes[4 * pixel + c] = srgb_byte(rgba[c] / alpha);
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
    return Error{path, "", std::string("cannot be written: ") + header.message, ErrorKind::device};
  }
  return file->commit(existing);
}

}  // namespace

Status write_png(const std::string& path, const Image& image, IfExists existing) {
  return io::guarded(path, [&]() -> Status {
    if (const Status status = image.validate(); !status) {
      return Error{path, status.error().field, status.error().reason, status.error().kind};
    }
    return io::guarded(path, [&] { return write(path, image, existing); });
  });
}

}  // namespace swept
