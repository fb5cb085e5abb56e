// What both kinds of EXR files begin with, and how their bytes get out. For splat/io's own sources.
#pragma once

#include <cstdint>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include <ImfHeader.h>
#include <ImfIO.h>

#include "splat/image.h"
#include "splat/io/atomic_file.h"
#include "splat/io/image_file.h"
#include "splat/result.h"

namespace swept {

/// OpenEXR's output onto a C stream, whose error flag outlives the destructors that swallow exceptions.
class FileStream : public Imf::OStream {
 public:
  FileStream(const std::string& name, std::FILE* stream) : Imf::OStream(name.c_str()), stream_(stream) {}

  void write(const char bytes[], int count) override {
    if (std::fwrite(bytes, 1, static_cast<std::size_t>(count), stream_) != static_cast<std::size_t>(count)) {
      throw std::runtime_error("a write failed; is the disk full?");
    }
    position_ += static_cast<std::uint64_t>(count);
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override {
    if (fseeko(stream_, static_cast<off_t>(position), SEEK_SET) != 0)
      throw std::runtime_error("a seek failed");
    position_ = position;
  }

 private:
  std::FILE* stream_;
  std::uint64_t position_ = 0;
};

/// Whether a header can say that.
[[nodiscard]] Status check(const ImageMetadata& metadata);

/// Windows, as those of an Image, and what image_file.h says of the metadata; no channels.
struct ExrWindow {
  int x, y, width, height, film_width, film_height;
};
[[nodiscard]] Imf::Header header_of(const ExrWindow& window, const ImageMetadata& metadata);

/// What `write` puts into a stream, whole or not at all. Errors: what it throws, but for want of memory.
template <class Write>
Status write_exr_file(const std::string& path, IfExists existing, const Write& write) {
  try {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return file.error();
    FileStream stream(path, file->stream());
    write(stream);
    return file->commit(existing);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    return Error{path, "", std::string("cannot be written: ") + problem.what(), ErrorKind::device};
  }
}

}  // namespace swept
