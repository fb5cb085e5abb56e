// The numbers in the body of a PLY file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "splat/io/ply_header.h"

namespace swept {

/// The numbers of the body, one after the other. next() gives none at the end or at what is no number;
/// fault() then tells which.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view body, PlyFormat format);

  std::optional<double> next(PlyType type);

  /// In ASCII, holds the numbers up to end_row() to one line, so that a short row cannot eat into the next.
  void begin_row();
  /// Whether nothing else stands in the row.
  bool end_row();

  [[nodiscard]] std::string fault() const;
  /// Whether `count` rows of `least_bytes` each are left.
  [[nodiscard]] bool can_hold(std::uint64_t count, std::uint64_t least_bytes) const;
  /// Bytes that a number of this type takes at the least.
  [[nodiscard]] std::size_t least_bytes(PlyType type) const { return ascii_ ? 2 : type.bytes; }
  [[nodiscard]] std::size_t bytes_left() const { return body_.size(); }
  /// What stands after the last element once all are read, for reports; blanks at the end of ASCII are
  /// nothing.
  [[nodiscard]] std::vector<std::string> unread() const;

 private:
  std::string_view body_, token_;
  bool ascii_, swap_, one_line_ = false;
};

}  // namespace swept
