// What every fuzzer needs: numbers made of bytes, and a check that ends the process, which is a finding.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "splat/result.h"

namespace swept::fuzz {

[[noreturn]] inline void fail(const char* what, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: does not hold: %s\n", file, line, what);
  std::abort();
}

#define SWEPT_HOLDS(condition) \
  ((condition) ? static_cast<void>(0) : ::swept::fuzz::fail(#condition, __FILE__, __LINE__))

/// An error names its file and says something.
inline void check_error(const Error& error, const char* file) {
  SWEPT_HOLDS(error.file == file);
  SWEPT_HOLDS(!error.reason.empty());
}

/// The input as a stream of numbers; zeros once it is used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  [[nodiscard]] bool empty() const { return size_ == 0; }

  std::uint8_t byte() { return raw<std::uint8_t>(); }
  int below(int count) { return byte() % count; }
  bool flag() { return byte() % 2 != 0; }

  /// A multiple of 2⁻¹⁵ in [0, 1], both ends often.
  double unit() {
    const int parts = raw<std::uint16_t>() % 0x8400;
    return parts > 0x8000 ? (parts % 2) : parts * 0x1p-15;
  }

  /// Any finite number, everyday ones more often than others.
  double real() {
    double x = 0.0;
    switch (byte() % 8) {
      case 0:
        return 0.0;
      case 1:
        return flag() ? 1.0 : -1.0;
      case 2:
      case 3:
        return raw<std::int16_t>() * 0x1p-12;
      case 4:
        return raw<std::int16_t>() * 0x1p-22;
      case 5:
        x = raw<float>();
        break;
      case 6:
        x = raw<double>();
        break;
      default:
        x = std::ldexp(flag() ? 1.0 : -1.0, raw<std::int16_t>() % 1074);
    }
    return std::isfinite(x) ? x : 0.0;
  }

  /// The same, in the range of float.
  float real_float() {
    const double x = real();
    return std::abs(x) <= 3.4e38 ? static_cast<float>(x) : 0.0f;
  }

 private:
  template <class T>
  T raw() {
    T value{};
    const std::size_t taken = size_ < sizeof value ? size_ : sizeof value;
    if (taken > 0) std::memcpy(&value, data_, taken);
    data_ += taken;
    size_ -= taken;
    return value;
  }

  const std::uint8_t* data_;
  std::size_t size_;
};

}  // namespace swept::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
