#include "splat/image.h"

#include <cstdint>
#include <limits>
#include <string>

namespace swept {

Status Image::validate() const {
  if (width < 1 || height < 1) return Error{"", "width, height", "an image needs at least one pixel"};
  if (film_width < 1 || film_height < 1) {
    return Error{"", "film_width, film_height", "a film needs at least one pixel"};
  }
  constexpr std::int64_t kMost = std::numeric_limits<int>::max();
  if (std::int64_t{x} + width > kMost || std::int64_t{y} + height > kMost) {
    return Error{"", "x, y", "the window's far corner is beyond the range of a pixel coordinate"};
  }
  const auto mismatch = [&](const char* name, std::size_t has, std::size_t wants) {
    return Error{"", name,
                 "has " + std::to_string(has) + " values where the window holds " + std::to_string(wants)};
  };
  if (rgba.size() != 4 * pixel_count()) return mismatch("rgba", rgba.size(), 4 * pixel_count());
  if (!depth.empty() && depth.size() != pixel_count()) return mismatch("depth", depth.size(), pixel_count());
  return Done{};
}

Image blank_image(const Film& film) {
  Image image;
  image.x = film.crop_x;
  image.y = film.crop_y;
  image.width = film.window_width();
  image.height = film.window_height();
  image.film_width = film.width;
  image.film_height = film.height;
  image.rgba.resize(4 * image.pixel_count());
  image.depth.resize(image.pixel_count());
  return image;
}

}  // namespace swept
