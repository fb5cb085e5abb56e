// Where the frames of a run go, decided and checked before anything is rendered.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "splat/io/image_file.h"
#include "splat/result.h"

namespace swept {

enum class Existing { refuse, overwrite, skip };

/// What one frame writes.
struct FrameOutput {
  double frame = 0.0;
  std::string image, preview, deep;  ///< paths; all but the first may be empty
  bool skip = false;                 ///< all of it exists already
  /// What to do with files that are there once the frame is done: those that were not there before, and that
  /// nobody asked to replace, are another run's.
  IfExists image_exists = IfExists::fail, preview_exists = IfExists::fail, deep_exists = IfExists::fail;
};

/// The paths of all frames. A pattern (%04d, ####) is needed if there are several frames, and is filled in if
/// there is one. The error's field is the option at fault.
[[nodiscard]] Result<std::vector<FrameOutput>> name_outputs(const std::vector<double>& frames,
                                                            const std::string& image,
                                                            const std::string& preview,
                                                            const std::string& deep = "");

/// What `image` would say of itself if it held this frame.
using OriginOf = std::function<Result<ExrOrigin>(const FrameOutput&)>;

/// Decides what is skipped, and refuses files that exist or cannot be written. Leaves no file behind. A frame
/// is skipped if its images are whole EXR files of just that origin, and its preview exists. Empty files
/// count as none, and any other is refused, so that nothing is lost that nobody asked to replace.
[[nodiscard]] Status check_outputs(std::vector<FrameOutput>& outputs, Existing existing,
                                   const OriginOf& origin_of);

/// The same for a single file that accompanies the frames; one that exists is replaced unless `refuse`.
[[nodiscard]] Status check_output_file(const std::string& path, Existing existing);

}  // namespace swept
