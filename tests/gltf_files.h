// glTF files for tests: a document and a buffer, in each of the ways they may come.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

namespace swept_test {

template <class T>
std::string raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

template <class T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) bytes += raw(value);
  return bytes;
}

inline std::string u32(std::size_t value) { return raw(static_cast<std::uint32_t>(value)); }

/// A .glb of a document and what its buffer 0 holds.
inline std::string glb(std::string json, std::string buffer) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
  const std::string chunks =
      u32(json.size()) + "JSON" + json + u32(buffer.size()) + std::string("BIN\0", 4) + buffer;
  return "glTF" + u32(2) + u32(12 + chunks.size()) + chunks;
}

inline std::string base64(const std::string& bytes) {
  const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace swept_test
