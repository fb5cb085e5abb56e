// What a test says about a reader's report.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/io/point_file.h"

namespace swept_test {

inline bool has_part(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

inline std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// Every property of the file is named, as used or as unread, and only once.
inline void expect_all_named(const swept::ReadReport& report, std::vector<std::string> properties) {
  std::vector<std::string> named = report.unread;
  for (const auto& use : report.used) named.insert(named.end(), use.properties.begin(), use.properties.end());
  std::sort(named.begin(), named.end());
  std::sort(properties.begin(), properties.end());
  EXPECT_EQ(named, properties);
}

}  // namespace swept_test
