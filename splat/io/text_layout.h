// What the columns of a text file are: from its header line, or from the numbers.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "splat/result.h"

namespace swept {

/// The lines before the first point.
struct TextHead {
  std::vector<std::string> names;    ///< of the columns, if a line gives them
  std::size_t names_line = 0;        ///< from 1
  bool names_in_comment = false;     ///< which may be a comment after all
  std::optional<std::size_t> count;  ///< of the points, if a line gives it
  std::size_t data = 0;              ///< offset of the first point's line
  std::size_t lines = 0;             ///< before it

  /// Holds the names against the number of columns. A comment with more or fewer names none, and `passed_by`
  /// says so; any other line is an error.
  [[nodiscard]] Status fit_names(const std::string& path, std::size_t columns, std::string& passed_by);
};

/// Names stand in the first line that is no comment, if none of its three or more words is a number; or in a
/// comment ("//X Y Z R G B", "# x y z") that names positions.
[[nodiscard]] TextHead read_text_head(std::string_view text, std::string_view separators);

/// Names for the columns of a file without a header. `values[c]` is column c, one number a point.
///   3     x y z
///   4     x y z intensity
///   6     x y z, and a normal if all have length 1 (to 2%) or 0
///         else a colour if none is negative or above 65535
///   7     x y z red green blue intensity, or x y z intensity red green blue (PTS)
///   9     x y z, and colours and normals in either order
/// The extensions .xyzn, .xyzrgb and .pts decide where they can. `assumed` gets a sentence on what was made
/// of the numbers. Errors: other numbers of columns, numbers that fit nothing or two things.
[[nodiscard]] Result<std::vector<std::string>> infer_text_columns(
    const std::string& path, const std::vector<std::vector<double>>& values, std::string& assumed);

/// Whether infer_text_columns has a meaning for so many columns.
[[nodiscard]] bool is_known_width(std::size_t columns);

/// Whether the row "1,5;2,5;3,5" or "1,5 2,5 3,5" has commas for decimal points, which nobody can tell from
/// separators for certain.
[[nodiscard]] bool has_decimal_commas(std::string_view line);

}  // namespace swept
