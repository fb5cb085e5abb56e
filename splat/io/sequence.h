// Numbered files and lists of frames.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// The file of a sequence: "walk.####.ply" (as many digits as there are #), printf's "walk.%04d.ply" and
/// "walk.%d.ply", Houdini's "walk.$F4.ply" and "walk.$F.ply". Longer numbers are never cut, and a minus sign
/// counts as a digit. The placeholder is in the file's name; a folder's name is what it is. Errors: no
/// placeholder, or more than one.
[[nodiscard]] Result<std::string> sequence_path(const std::string& pattern, int number);

/// Whether the file's name has a placeholder.
[[nodiscard]] bool is_sequence_pattern(const std::string& path);

/// sequence_path(), but of a negative number the file with the sign before all the digits where only that one
/// exists: -0001 for -001.
[[nodiscard]] Result<std::string> find_in_sequence(const std::string& pattern, int number);

struct NumberedFile {
  int number = 0;
  std::string path;
};

/// The existing files of a pattern, by increasing number. Errors: as sequence_path, an unreadable folder, no
/// such file, two files of one number.
[[nodiscard]] Result<std::vector<NumberedFile>> list_sequence(const std::string& pattern);

/// "1-100x2,120": ranges with an optional step ≥ 1, in the order given, each frame once. Errors: anything
/// else, ranges that run backwards, more than a million frames.
[[nodiscard]] Result<std::vector<int>> parse_frame_ranges(std::string_view text);

/// The same the other way: "1-99x2,105" of increasing numbers.
[[nodiscard]] std::string frame_ranges_text(const std::vector<int>& frames);

}  // namespace swept
