// Where pixels of the exact method go. For the project's own sources.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

#include "abuffer/deep_store.h"
#include "abuffer/sources/rasterize.h"
#include "splat/image.h"
#include "splat/interval/composite.h"

namespace swept {

/// An image, and what is asked for by depth. One thread at a time works on a pixel.
class FilmSink {
 public:
  /// All must outlive it; `deep` may be null.
  FilmSink(Image& image, const Eigen::Vector4f& background, DeepStore* deep)
      : image_(image), background_(background.cast<double>()), deep_(deep) {}

  [[nodiscard]] std::size_t index_of(int x, int y) const {
    return static_cast<std::size_t>(y - image_.y) * static_cast<std::size_t>(image_.width) +
           static_cast<std::size_t>(x - image_.x);
  }
  [[nodiscard]] bool wants_depths() const { return deep_ != nullptr; }
  /// Bytes of what is gathered by depth in a window.
  [[nodiscard]] std::size_t deep_bytes(const Window& window) const {
    std::size_t bytes = 0;
    if (deep_ == nullptr || !deep_->bounded()) return bytes;
    for (int y = window.y; y < window.y + window.height; ++y)
      for (int x = window.x; x < window.x + window.width; ++x) bytes += deep_->bytes_of(index_of(x, y));
    return bytes;
  }
  /// What pixel (x, y) adds up in.
  [[nodiscard]] PixelSum begin(int x, int y) {
    PixelSum pixel;
    if (deep_ != nullptr) pixel.by_depth = &deep_->pixel(index_of(x, y));
    return pixel;
  }
  void store(int x, int y, const PixelSum& pixel) {
    const std::size_t i = index_of(x, y);
    const double left = std::max(0.0, 1.0 - pixel.rgba[3]);
    for (int c = 0; c < 4; ++c)
      image_.rgba[4 * i + static_cast<std::size_t>(c)] =
          static_cast<float>(pixel.rgba[c] + left * background_[c]);
    image_.depth[i] = pixel.rgba[3] > 0.0 ? static_cast<float>(pixel.depth / pixel.rgba[3])
                                          : std::numeric_limits<float>::infinity();
  }
  /// Puts what `other` has of it in place of alpha and depth, and of colours if these are wanted.
  void replace(int x, int y, const Image& other, bool colors) {
    const std::size_t i = index_of(x, y);
    image_.depth[i] = other.depth[i];
    for (std::size_t c = colors ? 0 : 3; c < 4; ++c) image_.rgba[4 * i + c] = other.rgba[4 * i + c];
  }

 private:
  Image& image_;
  Eigen::Vector4d background_;
  DeepStore* deep_;
};

}  // namespace swept
