// Files that appear at their path complete, or not at all.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

#include "splat/result.h"

namespace swept {

/// A file being written under a temporary name in the folder of its final path.
///
/// commit() puts it in place, replacing an older file in one step; destroying an uncommitted AtomicFile
/// removes the temporary. An existing file at `path` is intact until then. Not synchronised to disk.
class AtomicFile {
 public:
  /// Creates the temporary `path`.tmpN, N the first free number. The error names `path`.
  [[nodiscard]] static Result<AtomicFile> create(const std::string& path);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();

  /// Open for writing and seeking, binary; closed by commit().
  [[nodiscard]] std::FILE* stream() const { return stream_; }

  /// Closes and renames. Any write to stream() that failed is an error here, and the temporary is removed.
  [[nodiscard]] Status commit();

 private:
  AtomicFile(std::string path, std::string temporary, std::FILE* stream);
  void discard();

  std::string path_, temporary_;  // temporary_ empty: committed, discarded or moved from
  std::FILE* stream_ = nullptr;
};

/// The whole file at once, in the same way.
[[nodiscard]] Status write_file(const std::string& path, std::string_view content);

}  // namespace swept
