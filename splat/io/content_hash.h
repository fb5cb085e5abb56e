// FNV-1a of 64 bits: tells contents apart that were not made to be confused. For splat/io's own sources.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "splat/result.h"

namespace swept::io {

class ContentHash {
 public:
  void add(std::string_view bytes) {
    for (const char c : bytes) state_ = (state_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  /// A part that ends where it ends: ("ab", "c") is not ("a", "bc").
  void add_part(std::string_view bytes) {
    add(std::to_string(bytes.size()) + ':');
    add(bytes);
  }
  /// 16 hexadecimal digits.
  [[nodiscard]] std::string text() const;

 private:
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

/// Of a file's size and content, 16 digits. Reads all of it, in little memory.
[[nodiscard]] Result<std::string> hash_file(const std::string& path);

}  // namespace swept::io
