// What a study ran on.
#pragma once

#include <string>

namespace swept {

struct Machine {
  std::string cpu, os, compiler;
  unsigned threads = 0;
  double memory_bytes = 0.0;
};

/// What cannot be found out is "unknown" or 0.
[[nodiscard]] Machine this_machine();

}  // namespace swept
