// What a caller sets about a render that does not change a bit of its image.
#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

struct RenderControl {
  int threads = 0;  ///< the most threads, [0, 1024]; 0: as many as the machine has
  /// The most memory for points as the renderer keeps them, beyond the scene itself; 0: no limit. A render
  /// that would need more returns an error.
  std::size_t max_bytes = 0;
  std::stop_token stop = {};  ///< checked now and then; a stopped render returns an error
  /// Called with the share that is done, in [0, 1] and never falling, by one thread at a time. If it throws,
  /// the render ends and returns an error.
  std::function<void(double)> progress = {};
  /// Called after a render that succeeded, by the thread that called the renderer, with each of
  /// Statistics::effects: a sentence that a person may want to know. The library prints nothing.
  std::function<void(const std::string&)> log = {};

  [[nodiscard]] Status validate() const {
    if (threads < 0 || threads > 1024) return Error{"", "threads", "must be in [0, 1024]"};
    return Done{};
  }
};

}  // namespace swept
