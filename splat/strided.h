// A view of a caller's array: values at even steps in memory, which belong to the caller.
#pragma once

#include <cstddef>
#include <vector>

#include "splat/export.h"

namespace SWEPT_API swept {

/// `count` values of type T, each `stride_bytes` after the one before: a column of a table, a member of an
/// array of structures, or an array read backwards.
template <class T>
struct Strided {
  const T* data = nullptr;
  std::size_t count = 0;
  std::ptrdiff_t stride_bytes = sizeof(T);

  Strided() = default;
  Strided(const T* first, std::size_t size, std::ptrdiff_t stride = sizeof(T))
      : data(first), count(size), stride_bytes(stride) {}
  Strided(const std::vector<T>& array) : data(array.data()), count(array.size()) {}

  [[nodiscard]] bool empty() const { return count == 0; }
  [[nodiscard]] const T& operator[](std::size_t i) const {
    return *reinterpret_cast<const T*>(reinterpret_cast<const char*>(data) +
                                       static_cast<std::ptrdiff_t>(i) * stride_bytes);
  }
};

}  // namespace swept
