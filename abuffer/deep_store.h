// What the exact method gathers of every pixel by depth. For the project's own sources.
#pragma once

#include <atomic>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "splat/deep_image.h"
#include "splat/image.h"
#include "splat/interval/depth_sum.h"
#include "splat/result.h"

namespace swept {

/// Pixels of one window, each of which one thread at a time works on. What is gathered through several points
/// of a lens adds up.
class DeepStore {
 public:
  /// May take `most` bytes; 0: as many as there are.
  explicit DeepStore(std::size_t most = 0) : most_(most) {}

  /// Errors: pixels alone take more than they may.
  [[nodiscard]] Status start(const Image& image) {
    if (pixels_.empty()) {
      bytes_ = image.pixel_count() * sizeof(DepthSum);
      if (full()) return full_error();
      pixels_.resize(image.pixel_count());
    }
    ++passes_;
    return Done{};
  }

  [[nodiscard]] bool bounded() const { return most_ > 0; }
  /// Bytes of what a pixel has gathered.
  [[nodiscard]] std::size_t bytes_of(std::size_t index) const {
    return std::as_const(pixels_[index]).parts().capacity() * sizeof(DepthPart);
  }
  /// What some pixels take has changed. From any thread.
  void changed(std::size_t bytes_before, std::size_t bytes_now) { bytes_ += bytes_now - bytes_before; }
  /// Whether all take more than they may.
  [[nodiscard]] bool full() const { return most_ > 0 && bytes_ > most_; }
  [[nodiscard]] Error full_error() const {
    return {"", "max_bytes", "samples by depth alone take more than " + std::to_string(most_) + " bytes",
            ErrorKind::out_of_memory};
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
  std::size_t most_;
  std::atomic<std::size_t> bytes_ = 0;  ///< of all pixels; wraps around and back
  std::vector<DepthSum> pixels_;
  int passes_ = 0;
};

}  // namespace swept
