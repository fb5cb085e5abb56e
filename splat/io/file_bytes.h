// A whole file in memory, and the numbers and lines of a text one.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// Errors: no such file, not a regular file, unreadable.
[[nodiscard]] Result<std::string> read_bytes(const std::string& path);

/// The number that `token` is from its first to its last character, whatever the locale; "nan" and "inf" too.
/// Beyond the range of double: infinity, or zero.
[[nodiscard]] std::optional<double> parse_number(std::string_view token);

/// Lines of a text without what follows a #, and the tokens of each.
class LineScanner {
 public:
  /// `separators` part tokens, besides space and tab. A line that ends in `continuation` goes on in the next;
  /// no token spans the two.
  explicit LineScanner(std::string_view text, std::string_view separators = "", char continuation = '\0');

  /// Moves to the next line that has a token; false at the end.
  bool next_line();
  /// The next token of this line; empty at its end.
  std::string_view next_token();
  /// From 1.
  [[nodiscard]] std::size_t line_number() const { return line_number_; }
  [[nodiscard]] std::size_t bytes_left() const { return text_.size(); }

 private:
  void take_line();

  std::string_view text_, line_;
  std::string blanks_;
  char continuation_;
  bool continues_ = false;  ///< line_ goes on in the next
  std::size_t line_number_ = 0;
};

/// "'abc' is not a number", with long or binary tokens cut short and made printable.
[[nodiscard]] std::string not_a_number(std::string_view token);

}  // namespace swept
