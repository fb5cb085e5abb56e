// An order of points that follows from where and what they are, not from how a file lists them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "abuffer/parallel.h"

namespace swept {

/// join(…) of what `of` returns for runs of [0, count), joined in their order.
template <class T, class Of, class Join>
T reduced(std::size_t count, T start, const Of& of, const Join& join) {
  constexpr std::size_t run = 1 << 14;
  std::vector<T> parts((count + run - 1) / run);
  parallel_for_each_index(parts.size(),
                          [&](std::size_t i) { parts[i] = of(i * run, std::min((i + 1) * run, count)); });
  for (const T& part : parts) start = join(start, part);
  return start;
}

/// Indices below `count` along a space-filling curve through `position(i)`, in cells of a millionth of the
/// points' range; those in one cell by `less(a, b)` of two indices. Runs in the caller's task arena, which
/// calls both from several threads.
[[nodiscard]] std::vector<std::uint32_t> content_order(
    std::size_t count, const std::function<Eigen::Vector3d(std::size_t)>& position,
    const std::function<bool(std::uint32_t, std::uint32_t)>& less);

}  // namespace swept
