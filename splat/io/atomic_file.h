// Files that appear at their path complete, or not at all.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

#include "splat/export.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// What becomes of a file that has appeared at the path since it was asked for.
enum class IfExists {
  replace,
  fail,  ///< an error, and the file stays as it is
};

/// A file being written under a temporary name in the folder of its final path.
///
/// commit() puts it in place, replacing an older file in one step; destroying an uncommitted AtomicFile
/// removes the temporary. An existing file at `path` is intact until then. Where `path` is a link, the file
/// that it leads to is written, and the link stays. Not synchronised to disk.
class AtomicFile {
 public:
  /// Creates the temporary `path`.tmpN, N the first free number; a shorter name where that is too long. A
  /// temporary that its writer left behind, as one that was killed does, is taken away. Errors name `path`:
  /// folders, pipes and devices in its place, and whatever the file system objects to.
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

/// The whole file at once, in the same way.
[[nodiscard]] Status write_file(const std::string& path, std::string_view content);

/// Removes the temporaries of all AtomicFiles of this process, none of which can be committed any more. For a
/// signal handler that ends the process: async-signal-safe.
void remove_temporaries() noexcept;

}  // namespace swept
