// Where the frames of a run go, decided and checked before anything is rendered.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "splat/result.h"

namespace swept {

enum class Existing { refuse, overwrite, skip };

/// What one frame writes.
struct FrameOutput {
  double frame = 0.0;
  std::string image, preview;  ///< paths; preview may be empty
  bool skip = false;           ///< all of it exists already
};

/// The paths of all frames. A pattern (%04d, ####) is needed if there are several frames, and is filled in if
/// there is one. The error's field is the option at fault.
[[nodiscard]] Result<std::vector<FrameOutput>> name_outputs(const std::vector<double>& frames,
                                                            const std::string& image,
                                                            const std::string& preview);

/// Decides what is skipped, and refuses files that exist or cannot be written. Leaves no file behind.
[[nodiscard]] Status check_outputs(std::vector<FrameOutput>& outputs, Existing existing);

/// The same for a single file that accompanies the frames; one that exists is replaced unless `refuse`.
[[nodiscard]] Status check_output_file(const std::string& path, Existing existing);

}  // namespace swept
