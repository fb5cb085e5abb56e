// A program run to its end, with text in and text out.
#pragma once

#include <string>
#include <vector>

#include "splat/result.h"

namespace swept {

struct ChildOutcome {
  std::string output;              ///< all of its stdout
  int exit_code = 0, signal = 0;   ///< one of them tells how it ended
  bool timed_out = false;          ///< it was killed for that
  double peak_memory_bytes = 0.0;  ///< resident
};

/// Runs `command` (path and arguments) with `input` on its stdin, at most a pipe's buffer of 64 KiB; its
/// stderr is discarded. The error is of starting it.
[[nodiscard]] Result<ChildOutcome> run_child(const std::vector<std::string>& command,
                                             const std::string& input, double limit_seconds);

}  // namespace swept
