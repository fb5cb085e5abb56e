#include <cstddef>

#include "splat/io/read_formats.h"

namespace swept {

void add_strips(const std::vector<std::int64_t>& strips, std::vector<Triangle>& triangles) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    if (strips[i] < 0) {
      begin = i + 1;
    } else if (i >= begin + 2) {
      auto a = static_cast<std::uint32_t>(strips[i - 2]), b = static_cast<std::uint32_t>(strips[i - 1]);
      const auto c = static_cast<std::uint32_t>(strips[i]);
      if (a == b || b == c || c == a) continue;
      if ((i - begin) % 2 != 0) std::swap(a, b);
      triangles.push_back({a, b, c});
    }
  }
}

}  // namespace swept
