// Numbered files and lists of frames.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "splat/result.h"

namespace swept {

/// The file of a sequence: "walk.####.ply" (as many digits as there are #) or printf's "walk.%04d.ply" and
/// "walk.%d.ply". Longer numbers are never cut. Errors: no placeholder, or more than one.
[[nodiscard]] Result<std::string> sequence_path(const std::string& pattern, int number);

struct NumberedFile {
  int number = 0;
  std::string path;
};

/// The existing files of a pattern (placeholder in the file name, not in a folder's), by increasing
/// number. Errors: as sequence_path, an unreadable folder, no such file.
[[nodiscard]] Result<std::vector<NumberedFile>> list_sequence(const std::string& pattern);

/// "1-100x2,120": ranges with an optional step ≥ 1, in the order given, each frame once. Errors: anything
/// else, ranges that run backwards, more than a million frames.
[[nodiscard]] Result<std::vector<int>> parse_frame_ranges(std::string_view text);

}  // namespace swept
