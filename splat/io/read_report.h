// What a reader made of a file: which properties became which attribute, which were left alone, what it
// assumed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "splat/export.h"

namespace SWEPT_API swept {

/// The report on one file. Points, colours and so on are in the PointSet; this says where they came from.
struct ReadReport {
  struct Use {
    std::string attribute;                ///< as in ReadOptions::attributes; also "alpha"
    std::vector<std::string> properties;  ///< the file's own names
    bool operator==(const Use&) const = default;
  };
  std::vector<Use> used;
  std::vector<std::string> unread;   ///< properties that were not used
  std::vector<std::string> assumed;  ///< what the file does not say, one sentence each
  std::size_t points = 0;            ///< in the file
  std::size_t dropped = 0;           ///< of these, those with numbers that are not finite

  /// The properties that became `attribute`; empty if none did.
  [[nodiscard]] std::vector<std::string> properties_of(const std::string& attribute) const;

  /// The report as lines for people: "read: …", "unread: …", "assumed: …". Numbered names are shortened to
  /// "f_rest_0 to f_rest_44".
  [[nodiscard]] std::vector<std::string> lines() const;
};

/// "a, b, f_0 to f_44": names separated by commas, with three or more numbered ones in a row shortened and
/// unprintable characters shown as "?".
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

}  // namespace swept
