// What tests pack splats with: gzip, zstd, zip archives, WebP, numbers as bytes.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <webp/encode.h>
#include <zlib.h>
#include <zstd.h>

namespace swept_test {

/// Packing does not fail; ends the process if it does.
inline void must(bool done) {
  if (!done) std::abort();
}

/// Little-endian bytes of a number, as is this machine.
template <class T>
std::string bytes_of(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}
inline std::string le16(std::size_t value) { return bytes_of(static_cast<std::uint16_t>(value)); }
inline std::string le32(std::size_t value) { return bytes_of(static_cast<std::uint32_t>(value)); }
inline std::string le64(std::size_t value) { return bytes_of(static_cast<std::uint64_t>(value)); }

inline std::string deflated(const std::string& bytes, int window_bits) {
  z_stream stream{};
  must(deflateInit2(&stream, 9, Z_DEFLATED, window_bits, 9, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string packed(deflateBound(&stream, bytes.size()) + 32, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  must(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

inline std::string gzip(const std::string& bytes) { return deflated(bytes, 15 + 16); }

inline std::string zstd(const std::string& bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 19);
  must(!ZSTD_isError(size));
  packed.resize(size);
  return packed;
}

/// A zip archive; stored, or packed by deflate.
inline std::string zip(const std::vector<std::pair<std::string, std::string>>& files, bool pack = false) {
  std::string archive, directory;
  for (const auto& [name, bytes] : files) {
    const std::string data = pack ? deflated(bytes, -15) : bytes;
    const auto crc = crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
    const std::string common = le16(20) + le16(0) + le16(pack ? 8 : 0) + le16(0) + le16(0x21) + le32(crc) +
                               le32(data.size()) + le32(bytes.size()) + le16(name.size()) + le16(0);
    directory +=
        "PK\1\2" + le16(20) + common + le16(0) + le16(0) + le16(0) + le32(0) + le32(archive.size()) + name;
    archive += "PK\3\4" + common + name + data;
  }
  return archive + directory + "PK\5\6" + le16(0) + le16(0) + le16(files.size()) + le16(files.size()) +
         le32(directory.size()) + le32(archive.size()) + le16(0);
}

/// RGBA to WebP, to the bit unless lossy.
inline std::string webp(int width, int height, const std::string& rgba, bool lossless = true) {
  WebPConfig config;
  must(WebPConfigInit(&config));
  config.lossless = lossless ? 1 : 0;
  config.exact = 1;
  WebPPicture picture;
  must(WebPPictureInit(&picture));
  picture.width = width;
  picture.height = height;
  picture.use_argb = 1;
  must(WebPPictureImportRGBA(&picture, reinterpret_cast<const std::uint8_t*>(rgba.data()), 4 * width));
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  must(WebPEncode(&config, &picture));
  std::string bytes(reinterpret_cast<const char*>(writer.mem), writer.size);
  WebPMemoryWriterClear(&writer);
  WebPPictureFree(&picture);
  return bytes;
}

}  // namespace swept_test
