// Wall time of one stage after another. For the project's own sources.
#pragma once

#include <chrono>
#include <utility>

namespace swept {

/// Seconds since the last call, or since it was made.
class Stopwatch {
 public:
  double lap() {
    const Clock::time_point last = std::exchange(start_, Clock::now());
    return std::chrono::duration<double>(start_ - last).count();
  }
  /// The same, and goes on.
  [[nodiscard]] double so_far() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace swept
