#include "splat/io/unpack.h"

#include <algorithm>
#include <limits>
#include <memory>

#include <zlib.h>
#include <zstd.h>

namespace swept::io {
namespace {

constexpr std::size_t first_room = std::size_t{1} << 16;

/// Makes room for more of `size` bytes, of which those in `bytes` have come.
void grow(std::string& bytes, std::size_t size) {
  bytes.resize(std::min(size, std::max(first_room, 2 * bytes.size())));
}

std::string ends_before(std::size_t have, std::size_t size) {
  return "ends after " + std::to_string(have) + " of " + std::to_string(size) + " bytes";
}

}  // namespace

struct GzipStream::State {
  z_stream zlib{};
  std::string_view packed;
  bool ready = false, ended = false;

  /// Fills up to `size` bytes from `out`; how many came. Negative: damaged.
  std::ptrdiff_t fill(char* out, std::size_t size) {
    if (!ready) return -1;
    constexpr std::size_t most = std::numeric_limits<uInt>::max();
    std::size_t filled = 0;
    while (filled < size && !ended) {
      const std::size_t in = std::min(packed.size(), most), room = std::min(size - filled, most);
      zlib.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
      zlib.avail_in = static_cast<uInt>(in);
      zlib.next_out = reinterpret_cast<Bytef*>(out + filled);
      zlib.avail_out = static_cast<uInt>(room);
      const int code = inflate(&zlib, Z_NO_FLUSH);
      packed.remove_prefix(in - zlib.avail_in);
      filled += room - zlib.avail_out;
      ended = code == Z_STREAM_END;
      if (code == Z_BUF_ERROR || (code == Z_OK && packed.empty() && zlib.avail_out > 0)) break;
      if (code != Z_OK && !ended) return -1;
    }
    return static_cast<std::ptrdiff_t>(filled);
  }
};

GzipStream::GzipStream(std::string_view packed) : state_(new State) {
  state_->packed = packed;
  constexpr int gzip = 16;
  state_->ready = inflateInit2(&state_->zlib, MAX_WBITS + gzip) == Z_OK;
}

GzipStream::~GzipStream() {
  if (state_->ready) inflateEnd(&state_->zlib);
  delete state_;
}

Result<std::string> GzipStream::next(std::size_t size) {
  std::string bytes;
  for (std::size_t have = 0; have < size;) {
    grow(bytes, size);
    const std::ptrdiff_t came = state_->fill(bytes.data() + have, bytes.size() - have);
    if (came < 0) return Error{"", "", "its gzip stream is damaged"};
    have += static_cast<std::size_t>(came);
    if (have < bytes.size()) return Error{"", "", "its gzip stream " + ends_before(have, size)};
  }
  return bytes;
}

bool GzipStream::at_end() {
  char more = 0;
  return state_->fill(&more, 1) == 0 && state_->ended && state_->packed.empty();
}

Result<std::string> unpack_zstd(std::string_view packed, std::size_t size) {
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          ZSTD_freeDStream);
  if (!stream) return Error{"", "", "not enough memory", ErrorKind::out_of_memory};
  // A frame may ask for a window of any size. Those who pack without knowing the size ask for 8 MiB.
  int window_log = 23;
  while (window_log < 31 && (std::size_t{1} << window_log) < size) ++window_log;
  ZSTD_DCtx_setParameter(stream.get(), ZSTD_d_windowLogMax, window_log);
  std::string bytes;
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  std::size_t have = 0, hint = 1;
  while (hint != 0 || in.pos < in.size) {
    if (have == bytes.size() && have < size) grow(bytes, size);
    char beyond = 0;
    ZSTD_outBuffer out{bytes.data() + have, bytes.size() - have, 0};
    if (have == size) out = {&beyond, 1, 0};
    const std::size_t in_before = in.pos;
    hint = ZSTD_decompressStream(stream.get(), &out, &in);
    if (ZSTD_isError(hint))
      return Error{"", "", std::string("its zstd stream is damaged: ") + ZSTD_getErrorName(hint)};
    if (have == size && out.pos > 0)
      return Error{"", "", "its zstd stream goes on after " + std::to_string(size) + " bytes"};
    have += have == size ? 0 : out.pos;
    if (out.pos == 0 && in.pos == in_before) break;
  }
  if (hint != 0 || have != size) return Error{"", "", "its zstd stream " + ends_before(have, size)};
  return bytes;
}

}  // namespace swept::io
