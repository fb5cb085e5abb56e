// Files that appear at their path complete, or not at all.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// What commit() does if there is a file at the path.
enum class IfExists {
  replace,  ///< the new file takes its place
  fail,     ///< commit() is an error, and the file stays as it is
};

/// A file being written under a temporary name in the folder of its final path.
///
/// commit() puts it in place, replacing an older file in one step; destroying an uncommitted AtomicFile
/// removes the temporary. An existing file at `path` is intact until then. Where `path` is a link, the file
/// that it leads to is written, and the link stays. Not synchronised to disk.
class AtomicFile {
 public:
  /// Creates the temporary `path`.tmpN, N being the first free number, or a shorter name if that is too long.
  /// A temporary that a killed writer left behind is removed. Errors name `path`: a folder, pipe or device in
  /// its place, and what the file system objects to.
  [[nodiscard]] static Result<AtomicFile> create(const std::string& path);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();

  /// Open for writing and seeking, binary; closed by commit().
  [[nodiscard]] std::FILE* stream() const { return stream_; }

  /// Closes and renames. Any write to stream() that failed is an error here, and the temporary is removed.
  [[nodiscard]] Status commit(IfExists existing = IfExists::replace);

 private:
  AtomicFile() = default;
  [[nodiscard]] Error error(const char* what, int code) const;
  [[nodiscard]] bool try_name(const std::string& name);
  void discard();

  std::string path_, target_, temporary_;  // temporary_ empty: committed, discarded or moved from
  std::FILE* stream_ = nullptr;
  int slot_ = -1;  // in the list that remove_temporaries() goes through; -1: none
};

/// Writes a whole file at once, as an AtomicFile does. Errors: as create() and commit().
[[nodiscard]] Status write_file(const std::string& path, std::string_view content);

/// Removes the temporaries of all AtomicFiles of this process; none of these can be committed after that.
/// Async-signal-safe, for a signal handler that ends the process.
void remove_temporaries() noexcept;

}  // namespace swept
