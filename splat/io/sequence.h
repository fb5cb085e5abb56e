// Numbered files and lists of frames.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// The path of file `number` of a sequence. Patterns are "walk.####.ply" (as many digits as there are #),
/// printf's "walk.%04d.ply" and "walk.%d.ply", and Houdini's "walk.$F4.ply" and "walk.$F.ply". Longer numbers
/// are never cut, and a minus sign counts as a digit. The placeholder is in the file's name; names of folders
/// are taken as they are. Errors: no placeholder, or more than one.
[[nodiscard]] Result<std::string> sequence_path(const std::string& pattern, int number);

/// Whether the file's name has a placeholder.
[[nodiscard]] bool is_sequence_pattern(const std::string& path);

/// sequence_path(); but for a negative number the path with the sign before all the digits (-0001 for -001),
/// if only that file exists.
[[nodiscard]] Result<std::string> find_in_sequence(const std::string& pattern, int number);

struct NumberedFile {
  int number = 0;
  std::string path;
};

/// The existing files of a pattern, by increasing number. Errors: as sequence_path, an unreadable folder, no
/// such file, two files of one number.
[[nodiscard]] Result<std::vector<NumberedFile>> list_sequence(const std::string& pattern);

/// The frames of a text such as "1-100x2,120": ranges with an optional step ≥ 1, in the order given, each
/// frame once. Errors: other texts, ranges that run backwards, more than a million frames.
[[nodiscard]] Result<std::vector<int>> parse_frame_ranges(std::string_view text);

/// The inverse for increasing numbers: "1-99x2,105".
[[nodiscard]] std::string frame_ranges_text(const std::vector<int>& frames);

}  // namespace swept
