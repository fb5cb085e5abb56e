// Which squares of a window a large moving triangle stays out of. Source: Gribel et al. 2013, section 4.2.
#pragma once

#include <cstddef>
#include <vector>

#include "abuffer/sources/rasterize.h"

namespace swept {

/// A thread's, for one triangle after the other.
class BlockTests {
 public:
  /// `large`: it is worth the while, else none is ever known to be missed.
  void start(const Window& window, bool large) {
    large_ = large;
    if (!large) return;
    window_ = window;
    columns_ = (window.width + block_px - 1) / block_px;
    known_.assign(static_cast<std::size_t>(columns_) *
                      static_cast<std::size_t>((window.height + block_px - 1) / block_px),
                  unknown);
  }
  /// Whether the block of pixel (x, y) is missed; test(middle_x, middle_y, half_px) tells, once a block.
  template <class Test>
  [[nodiscard]] bool misses(int x, int y, const Test& test) {
    if (!large_) return false;
    const int column = (x - window_.x) / block_px, row = (y - window_.y) / block_px;
    State& state = known_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                          static_cast<std::size_t>(column)];
    if (state == unknown)
      state = test(window_.x + (column + 0.5) * block_px, window_.y + (row + 0.5) * block_px, 0.5 * block_px)
                  ? missed
                  : near;
    return state == missed;
  }

 private:
  static constexpr int block_px = 8;
  enum State : char { unknown, missed, near };

  bool large_ = false;
  Window window_{};
  int columns_ = 0;
  std::vector<State> known_;
};

}  // namespace swept
