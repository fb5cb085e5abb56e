// What a caller decides about a render that changes no bit of its image.
#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

struct RenderControl {
  int threads = 0;  ///< at most so many, [0, 1024]; 0: as many as the machine has
  std::size_t max_bytes =
      0;  ///< of memory for points as the renderer keeps them, beyond the scene; 0: no limit
  std::stop_token stop = {};  ///< asked for now and then; a stopped render returns an error
  /// Called with the share that is done, in [0, 1] and never falling, by one thread at a time. What it
  /// throws ends the render, which returns an error.
  std::function<void(double)> progress = {};
  /// Called with what a person may want to know about a render that succeeded, a sentence at a time, by the
  /// thread that called the renderer: Statistics::effects as they are. The library says nothing elsewhere.
  std::function<void(const std::string&)> log = {};

  [[nodiscard]] Status validate() const {
    if (threads < 0 || threads > 1024) return Error{"", "threads", "must be in [0, 1024]"};
    return Done{};
  }
};

}  // namespace swept
