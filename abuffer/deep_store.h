// What the exact method gathers of every pixel by depth. For the project's own sources.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "splat/deep_image.h"
#include "splat/image.h"
#include "splat/interval/depth_sum.h"

namespace swept {

/// Pixels of one window, each of which one thread at a time works on. What is gathered through several points
/// of a lens adds up.
class DeepStore {
 public:
  void start(const Image& image) {
    if (pixels_.empty()) pixels_.resize(image.pixel_count());
    ++passes_;
  }

  [[nodiscard]] DepthSum& pixel(std::size_t index) { return pixels_[index]; }

  /// Of the window that `image` has. Gives up what was gathered as it goes.
  [[nodiscard]] DeepImage finish(const Image& image, const Eigen::Vector4d& background) {
    DeepImage deep{image.x, image.y, image.width, image.height, image.film_width, image.film_height,
                   {},      {},      {}};
    for (DepthSum& pixel : pixels_)
      append_pixel(std::exchange(pixel, {}).parts(), 1.0 / passes_, background, deep);
    pixels_.clear();
    return deep;
  }

 private:
  std::vector<DepthSum> pixels_;
  int passes_ = 0;
};

}  // namespace swept
