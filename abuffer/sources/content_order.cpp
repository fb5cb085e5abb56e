#include "abuffer/sources/content_order.h"

#include <array>
#include <limits>

namespace swept {
namespace {

/// Place along the Hilbert curve through a cube of 1024³ cells, which never jumps: neighbours along it are
/// neighbours in space. Source: Skilling, Programming the Hilbert curve (2004).
std::uint32_t along_hilbert_curve(std::array<std::uint32_t, 3> x) {
  constexpr std::uint32_t top = 1u << 9;
  for (std::uint32_t q = top; q > 1; q >>= 1) {
    const std::uint32_t below = q - 1;
    for (int i = 0; i < 3; ++i) {
      if (x[i] & q) {
        x[0] ^= below;
      } else {
        const std::uint32_t swapped = (x[0] ^ x[i]) & below;
        x[0] ^= swapped;
        x[i] ^= swapped;
      }
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t turned = 0;
  for (std::uint32_t q = top; q > 1; q >>= 1)
    if (x[2] & q) turned ^= q - 1;
  std::uint32_t place = 0;
  for (int bit = 9; bit >= 0; --bit)
    for (int i = 0; i < 3; ++i) place = place << 1 | ((x[i] ^ turned) >> bit & 1u);
  return place;
}

struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
};

/// Least significant digit first, in three digits of 10 bits: the upper halves decide, equal ones keep their
/// order.
void sort_by_upper_half(std::vector<std::uint64_t>& entries) {
  constexpr std::size_t digits = 1024;
  std::vector<std::uint64_t> other(entries.size());
  for (int shift = 32; shift < 62; shift += 10) {
    std::array<std::size_t, digits + 1> starts{};
    for (const std::uint64_t entry : entries) ++starts[((entry >> shift) & (digits - 1)) + 1];
    for (std::size_t d = 0; d < digits; ++d) starts[d + 1] += starts[d];
    for (const std::uint64_t entry : entries) other[starts[(entry >> shift) & (digits - 1)]++] = entry;
    entries.swap(other);
  }
}

}  // namespace

std::vector<std::uint32_t> content_order(std::size_t count,
                                         const std::function<Eigen::Vector3d(std::size_t)>& position,
                                         const std::function<bool(std::uint32_t, std::uint32_t)>& less) {
  const auto [low, high] = reduced(
      count, Box{},
      [&](std::size_t begin, std::size_t end) {
        Box box;
        for (std::size_t i = begin; i != end; ++i) {
          const Eigen::Vector3d p = position(i);
          box = {box.low.cwiseMin(p), box.high.cwiseMax(p)};
        }
        return box;
      },
      [](const Box& a, const Box& b) {
        return Box{a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)};
      });
  // Halves, and a quotient of differences: neither overflows.
  const Eigen::Vector3d range = 0.5 * high - 0.5 * low;
  const double widest = range.maxCoeff();
  std::vector<std::uint64_t> entries(count);
  parallel_for_each_index(count, [&, low = low](std::size_t i) {
    const Eigen::Vector3d at = position(i);
    std::array<std::uint32_t, 3> cell{};
    for (int axis = 0; axis < 3; ++axis) {
      const double place = widest > 0.0 ? (0.5 * at[axis] - 0.5 * low[axis]) / widest : 0.0;
      cell[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(place * 1023.0);
    }
    entries[i] = std::uint64_t{along_hilbert_curve(cell)} << 32 | i;
  });
  sort_by_upper_half(entries);
  for (std::size_t first = 0; first < count;) {
    std::size_t last = first + 1;
    while (last < count && entries[last] >> 32 == entries[first] >> 32) ++last;
    if (last - first > 1)
      std::sort(entries.begin() + static_cast<std::ptrdiff_t>(first),
                entries.begin() + static_cast<std::ptrdiff_t>(last), [&](std::uint64_t a, std::uint64_t b) {
                  return less(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
                });
    first = last;
  }
  std::vector<std::uint32_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<std::uint32_t>(entries[i]);
  return order;
}

}  // namespace swept
