#include "splat/image.h"
#include "splat/without_throwing.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>

namespace swept {

Status Image::validate() const {
  return without_throwing("to check the image", [&]() -> Status {
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
    if (!depth.empty() && depth.size() != pixel_count())
      return mismatch("depth", depth.size(), pixel_count());
    for (std::size_t i = 0; i < channels.size(); ++i) {
      const ImageChannel& channel = channels[i];
      if (channel.values.size() != pixel_count())
        return mismatch("channels", channel.values.size(), pixel_count());
      const auto same = [&](const ImageChannel& other) { return other.name == channel.name; };
      constexpr std::string_view own[] = {"", "R", "G", "B", "A", "Z"};
      if (std::find(std::begin(own), std::end(own), channel.name) != std::end(own) ||
          std::find_if(channels.begin(), channels.begin() + static_cast<std::ptrdiff_t>(i), same) !=
              channels.begin() + static_cast<std::ptrdiff_t>(i))
        return Error{"", "channels",
                     "has two that are called \"" + channel.name + "\", or one without a name"};
    }
    return Done{};
  });
}

Image blank_image(const Film& film) {
  Image image;
  image.x = film.window_x();
  image.y = film.window_y();
  image.width = film.window_width();
  image.height = film.window_height();
  image.film_width = film.width;
  image.film_height = film.height;
  image.rgba.resize(4 * image.pixel_count());
  image.depth.resize(image.pixel_count());
  return image;
}

}  // namespace swept
