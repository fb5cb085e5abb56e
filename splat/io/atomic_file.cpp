#include "splat/io/atomic_file.h"

#include <cerrno>
#include <system_error>
#include <utility>

namespace swept {
namespace {

// Leftovers of killed runs keep their numbers; a folder with this many has another problem.
constexpr int kMostTemporaries = 10000;

Error system_error(const std::string& path, const char* what, int code) {
  return {path, "", std::string(what) + ": " + std::generic_category().message(code)};
}

}  // namespace

AtomicFile::AtomicFile(std::string path, std::string temporary, std::FILE* stream)
    : path_(std::move(path)), temporary_(std::move(temporary)), stream_(stream) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::exchange(other.path_, {})),
      temporary_(std::exchange(other.temporary_, {})),
      stream_(std::exchange(other.stream_, nullptr)) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(temporary_, other.temporary_);
  std::swap(stream_, other.stream_);
  return *this;
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() {
  if (stream_ != nullptr) std::fclose(std::exchange(stream_, nullptr));
  if (!temporary_.empty()) std::remove(std::exchange(temporary_, {}).c_str());
}

Result<AtomicFile> AtomicFile::create(const std::string& path) {
  if (path.empty()) return Error{"", "path", "an output file needs a name"};
  for (int n = 0; n < kMostTemporaries; ++n) {
    std::string temporary = path + ".tmp" + std::to_string(n);
    // "x": never the temporary of another process that writes the same path.
    if (std::FILE* stream = std::fopen(temporary.c_str(), "w+bx")) {
      return AtomicFile(path, std::move(temporary), stream);
    }
    if (errno != EEXIST) return system_error(path, "cannot be written", errno);
  }
  return Error{path, "",
               "cannot be written: its folder is full of abandoned temporary files " + path + ".tmpN"};
}

Status AtomicFile::commit() {
  // A write that failed earlier has left its errno behind long ago.
  const bool written = std::ferror(stream_) == 0;
  errno = 0;
  const bool closed = std::fclose(std::exchange(stream_, nullptr)) == 0;
  const int close_code = errno;
  if (!written || !closed) {
    discard();
    if (!closed) return system_error(path_, "cannot be written", close_code);
    return Error{path_, "", "not all of it could be written; is the disk full?"};
  }
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) {
    const int code = errno;
    discard();
    return system_error(path_, "cannot be put in place", code);
  }
  temporary_.clear();
  return Done{};
}

Status write_file(const std::string& path, std::string_view content) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  // A short write sets the stream's error, which commit reports.
  std::fwrite(content.data(), 1, content.size(), file->stream());
  return file->commit();
}

}  // namespace swept
