// What gzip and zstd packed, unpacked to a size that is known before. Private to splat/io.
//
// A few bytes can unpack to gigabytes. Whoever calls these says how many bytes are to come out; memory grows
// with what has come out, and one byte more or less is an error.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "splat/result.h"

namespace swept::io {

/// Bytes out of a gzip file, as they are asked for.
class GzipStream {
 public:
  explicit GzipStream(std::string_view packed);
  ~GzipStream();
  GzipStream(const GzipStream&) = delete;
  GzipStream& operator=(const GzipStream&) = delete;

  /// The next `size` bytes. Errors, without file and field: the stream ends before, or is damaged.
  Result<std::string> next(std::size_t size);
  /// Whether the stream ends here, whole and with the right checksum, and nothing follows it.
  bool at_end();

 private:
  struct State;
  State* state_;
};

/// Errors, without file and field: `packed` is damaged or does not unpack to `size` bytes.
[[nodiscard]] Result<std::string> unpack_zstd(std::string_view packed, std::size_t size);

}  // namespace swept::io
