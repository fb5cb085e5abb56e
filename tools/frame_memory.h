// Whether a frame fits into memory at all, before any of it is taken: Linux lends more than it has, and ends
// the process when it is used.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "splat/camera.h"
#include "splat/result.h"
#include "tools/layer_options.h"

namespace swept {

/// What a process may still take.
struct MemoryLeft {
  std::uint64_t bytes = 0;
  std::string whose;  ///< "the machine has", "--max-memory leaves"
};

/// The least of what the machine, the control group and --max-memory (`most` bytes; 0: no bound) leave. None:
/// the system does not say.
[[nodiscard]] std::optional<MemoryLeft> memory_left(std::uint64_t most);

/// What the picture of the film's window takes, colours, depth and layers, and nothing else does not.
[[nodiscard]] std::uint64_t least_frame_bytes(const Film& film, const LayerOptions& layers);

/// An error of kind out_of_memory that names both, if the picture takes more than is left.
[[nodiscard]] Status check_frame_memory(const Film& film, const LayerOptions& layers,
                                        const std::optional<MemoryLeft>& left);

}  // namespace swept
