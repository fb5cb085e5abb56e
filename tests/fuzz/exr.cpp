// Fuzzes the reading of OpenEXR files, which come by path: the bytes are a file in memory.
#include <cstdlib>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

#include "splat/io/image_file.h"
#include "tests/fuzz/check.h"

namespace {

/// A file without a folder, reopened for every input.
class MemoryFile {
 public:
  MemoryFile()
      : descriptor_(memfd_create("fuzzed", 0)), path_("/proc/self/fd/" + std::to_string(descriptor_)) {
    SWEPT_HOLDS(descriptor_ >= 0);
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const std::string& with(const std::uint8_t* data, std::size_t size) {
    SWEPT_HOLDS(ftruncate(descriptor_, 0) == 0);
    SWEPT_HOLDS(pwrite(descriptor_, data, size, 0) == static_cast<ssize_t>(size));
    return path_;
  }

 private:
  int descriptor_;
  std::string path_;
};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static MemoryFile file;
  const std::string& path = file.with(data, size);
  const swept::Result<swept::Image> image = swept::read_exr(path);
  if (image)
    SWEPT_HOLDS(image->validate());
  else
    swept::fuzz::check_error(image.error(), path.c_str());
  return 0;
}
