// Point files for tests: written here in every encoding, or found in the folder of real data.
#pragma once

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace swept_test {

class PointFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    swept::test::put(folder_ / name, bytes);
    return folder_ / name;
  }
  swept::test::TemporaryFolder folder_;
};

/// The folder of real data, or a skipped test.
#define SWEPT_DATA_OR_SKIP(name)                                              \
  const char* const name##_env = std::getenv("SWEPT_DATA_DIR");               \
  if (!name##_env || !*name##_env) GTEST_SKIP() << "SWEPT_DATA_DIR is unset"; \
  const std::string name = std::string(name##_env) + "/"

/// Numbers in one of PLY's three encodings.
class PlyBody {
 public:
  explicit PlyBody(const std::string& format) : format_(format) {}

  PlyBody& put(const std::string& type, double value) {
    if (type == "char" || type == "int8") return put_as<std::int8_t>(value);
    if (type == "uchar" || type == "uint8") return put_as<std::uint8_t>(value);
    if (type == "short" || type == "int16") return put_as<std::int16_t>(value);
    if (type == "ushort" || type == "uint16") return put_as<std::uint16_t>(value);
    if (type == "int" || type == "int32") return put_as<std::int32_t>(value);
    if (type == "uint" || type == "uint32") return put_as<std::uint32_t>(value);
    if (type == "float" || type == "float32") return put_as<float>(value);
    return put_as<double>(value);
  }
  void end_row() {
    if (format_ == "ascii") bytes_ += "\n";
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  template <class T>
  PlyBody& put_as(double value) {
    const T number = static_cast<T>(value);
    if (format_ == "ascii") {
      std::ostringstream text;
      text.precision(17);
      text << +number << ' ';
      bytes_ += text.str();
      return *this;
    }
    std::string raw(sizeof number, '\0');
    std::memcpy(raw.data(), &number, sizeof number);
    const bool big = format_ == "binary_big_endian";
    if (big != (std::endian::native == std::endian::big)) raw.assign(raw.rbegin(), raw.rend());
    bytes_ += raw;
    return *this;
  }

  std::string format_, bytes_;
};

inline const std::vector<std::string> kPlyFormats{"ascii", "binary_little_endian", "binary_big_endian"};

/// A PLY file of float vertices with the given property names, a row each.
inline std::string float_ply(const std::string& format, const std::vector<std::string>& names,
                             const std::vector<std::vector<double>>& rows) {
  std::string header = "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(rows.size()) + "\n";
  for (const std::string& name : names) header += "property float " + name + "\n";
  PlyBody body(format);
  for (const auto& row : rows) {
    for (const double value : row) body.put("float", value);
    body.end_row();
  }
  return header + "end_header\n" + body.bytes();
}

}  // namespace swept_test
