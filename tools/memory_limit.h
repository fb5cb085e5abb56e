// How much memory the process may have.
#pragma once

#include <cstdint>

#include "splat/result.h"

namespace swept {

/// From now on the process has at most so many bytes of data, its threads' stacks among them (Linux's
/// RLIMIT_DATA); what would take more ends as an error of kind out_of_memory. Errors: the system refuses.
[[nodiscard]] Status limit_memory(std::uint64_t bytes);

}  // namespace swept
