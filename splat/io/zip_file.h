// The files in a zip archive in memory. Private to splat/io.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "splat/result.h"

namespace swept::io {

class ZipFile {
 public:
  /// `bytes` have to stay. Errors, here and below, without file and field.
  static Result<ZipFile> open(std::string_view bytes);

  /// What is stored under `name`. Errors: nothing is, it unpacks to more than `most` bytes, its checksum is
  /// wrong, it is packed in a way that is not known or encrypted.
  [[nodiscard]] Result<std::string> read(const std::string& name, std::size_t most) const;

 private:
  struct Close {
    void operator()(void* archive) const;
  };
  explicit ZipFile(void* archive) : archive_(archive) {}

  std::unique_ptr<void, Close> archive_;
};

}  // namespace swept::io
