#include "splat/io/texture_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <png.h>

#include "splat/io/file_bytes.h"
#include "splat/io/guarded.h"
#include "splat/io/image_file.h"
#include "splat/srgb.h"

namespace swept {
namespace {

constexpr std::size_t most_texels = std::size_t{1} << 28;
/// No deflate stream holds more bytes for each of its own.
constexpr double most_inflation = 1032.0;

/// libpng's simple interface, which jumps past no C++ object. Ends what was begun.
class PngReader {
 public:
  PngReader(const std::string& path, const std::string& bytes) : path_(path) {
    image_.version = PNG_IMAGE_VERSION;
    begun_ = png_image_begin_read_from_memory(&image_, bytes.data(), bytes.size()) != 0;
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_image_free(&image_); }

  Result<Texture> read(std::size_t file_bytes) {
    if (!begun_) return fault();
    const std::size_t count = std::size_t{image_.width} * image_.height;
    if (count > most_texels) return Error{path_, "", "has more than 2^28 texels", ErrorKind::unsupported};
    // A pixel takes a bit at least.
    if (static_cast<double>(count) / 8.0 > most_inflation * static_cast<double>(file_bytes))
      return Error{path_, "", "has more texels than its bytes can hold", ErrorKind::malformed};
    Texture texture;
    texture.width = static_cast<int>(image_.width);
    texture.height = static_cast<int>(image_.height);
    const bool linear = (image_.format & PNG_FORMAT_FLAG_LINEAR) != 0;
    if (Status read = linear ? read_linear(count, texture) : read_srgb(count, texture); !read)
      return read.error();
    return texture;
  }

 private:
  /// Premultiplied by libpng.
  Status read_linear(std::size_t count, Texture& texture) {
    image_.format = PNG_FORMAT_LINEAR_RGB_ALPHA;
    std::vector<std::uint16_t> words(4 * count);
    if (png_image_finish_read(&image_, nullptr, words.data(), 0, nullptr) == 0) return fault();
    texture.texels.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Vector4f texel;
      for (std::size_t c = 0; c < 4; ++c)
        texel[static_cast<Eigen::Index>(c)] = static_cast<float>(words[4 * i + c]) / 65535.0f;
      texture.texels.push_back(texel);
    }
    return Done{};
  }

  Status read_srgb(std::size_t count, Texture& texture) {
    image_.format = PNG_FORMAT_RGBA;
    std::vector<std::uint8_t> bytes(4 * count);
    if (png_image_finish_read(&image_, nullptr, bytes.data(), 0, nullptr) == 0) return fault();
    std::array<float, 256> light;
    for (std::size_t b = 0; b < light.size(); ++b)
      light[b] = static_cast<float>(srgb_to_linear(static_cast<double>(b) / 255.0));
    texture.texels.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint8_t* rgba = &bytes[4 * i];
      const float alpha = static_cast<float>(rgba[3]) / 255.0f;
      texture.texels.emplace_back(alpha * light[rgba[0]], alpha * light[rgba[1]], alpha * light[rgba[2]],
                                  alpha);
    }
    return Done{};
  }

  [[nodiscard]] Error fault() const {
    return {path_, "", std::string("cannot be read as PNG: ") + image_.message, ErrorKind::malformed};
  }

  const std::string& path_;
  png_image image_{};
  bool begun_ = false;
};

Result<Texture> texture_of(const Image& image) {
  Texture texture;
  texture.width = image.width;
  texture.height = image.height;
  texture.texels.reserve(image.pixel_count());
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    texture.texels.emplace_back(image.rgba[4 * i], image.rgba[4 * i + 1], image.rgba[4 * i + 2],
                                image.rgba[4 * i + 3]);
  return texture;
}

Result<Texture> read(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".exr") {
    const Result<Image> image = read_exr(path);
    if (!image) return image.error();
    if (image->pixel_count() > most_texels)
      return Error{path, "", "has more than 2^28 texels", ErrorKind::unsupported};
    return texture_of(*image);
  }
  if (extension != ".png")
    return Error{path, "", "textures are read from .png and .exr", ErrorKind::unsupported};
  const Result<std::string> bytes = read_bytes(path);
  if (!bytes) return bytes.error();
  return PngReader(path, *bytes).read(bytes->size());
}

}  // namespace

Result<Texture> read_texture(const std::string& path) {
  return io::guarded(path, [&]() -> Result<Texture> {
    Result<Texture> texture = read(path);
    if (!texture) return texture;
    if (const Status valid = texture->validate(); !valid)
      return Error{path, valid.error().field, valid.error().reason, ErrorKind::malformed};
    return texture;
  });
}

}  // namespace swept
