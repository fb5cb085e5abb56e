// What benchmarks count time by: CPU seconds of the process, all threads together.
#pragma once

#include <ctime>

namespace swept {

[[nodiscard]] inline double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace swept
