#include "splat/io/gltf_bytes.h"

#include <cstdint>
#include <cstring>
#include <filesystem>

#include "splat/result.h"

namespace swept::io {
namespace {

constexpr std::uint32_t json_chunk = 0x4e4f534a, binary_chunk = 0x004e4942;

std::uint32_t word_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

}  // namespace

GltfChunks split_gltf(const std::string& path, std::string_view bytes) {
  if (!bytes.starts_with("glTF")) return {bytes, std::nullopt};
  const auto fail = [&](const std::string& field, const std::string& reason) -> GltfChunks {
    throw Error{path, field, reason};
  };
  if (bytes.size() < 12) return fail("header", "the file ends here");
  if (const std::uint32_t version = word_at(bytes, 4); version != 2)
    return fail("header", "has version " + std::to_string(version) + " of glTF, not 2");
  if (const std::uint32_t length = word_at(bytes, 8); length != bytes.size())
    return fail("header", "promises " + std::to_string(length) + " bytes, the file has " +
                              std::to_string(bytes.size()));
  GltfChunks chunks;
  bool has_json = false;
  for (std::string_view left = bytes.substr(12); !left.empty();) {
    if (left.size() < 8) return fail("chunk", "the file ends within its header");
    const std::uint32_t length = word_at(left, 0), type = word_at(left, 4);
    left.remove_prefix(8);
    if (length > left.size())
      return fail("chunk", "promises " + std::to_string(length) + " bytes, the file has " +
                               std::to_string(left.size()) + " left");
    if (!has_json && type != json_chunk) return fail("chunk", "the first one is not of JSON");
    if (!has_json)
      chunks.json = left.substr(0, length);
    else if (type == binary_chunk && !chunks.binary)
      chunks.binary = left.substr(0, length);  // others are for extensions to know
    has_json = true;
    left.remove_prefix(length);
  }
  if (!has_json) return fail("chunk", "there is none");
  return chunks;
}

std::optional<std::string> data_of_uri(std::string_view uri) {
  constexpr std::string_view mark = ";base64,";
  const std::size_t at = uri.find(mark);
  if (!uri.starts_with("data:") || at == uri.npos || uri.find(',') < at) return std::nullopt;
  std::string_view text = uri.substr(at + mark.size());
  // Padding may be left out, but not be in excess.
  for (int k = 0; k < 2 && text.ends_with('='); ++k) text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) return std::nullopt;
    word = (word << 6) | static_cast<std::uint32_t>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>((word >> bits) & 0xff);
  }
  return bytes;
}

std::optional<std::string> file_of_uri(const std::string& path, std::string_view uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const int high = uri[i] == '%' && i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
    const int low = high >= 0 ? hex_digit(uri[i + 2]) : -1;
    if (low >= 0) i += 2;
    name += low >= 0 ? static_cast<char>(16 * high + low) : uri[i];
  }
  // A scheme ends with a colon before the first slash.
  const std::size_t colon = uri.find(':');
  if (uri.empty() || (colon != uri.npos && colon < uri.find('/')) || name.find('\0') != name.npos)
    return std::nullopt;
  const std::filesystem::path relative(name);
  if (relative.is_absolute()) return std::nullopt;
  return (std::filesystem::path(path).parent_path() / relative).string();
}

}  // namespace swept::io
