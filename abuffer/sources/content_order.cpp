#include "abuffer/sources/content_order.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "abuffer/unset_array.h"

namespace swept {
namespace {

/// Bits of a number's low ten, with two empty ones before each.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ffu;
  x = (x | x << 8) & 0x0300f00fu;
  x = (x | x << 4) & 0x030c30c3u;
  return (x | x << 2) & 0x09249249u;
}

/// Cells of sixteen points: as many as a processor takes side by side.
constexpr std::size_t batch = 16;
struct Cells {
  std::uint32_t of[3][batch];

  [[nodiscard]] std::uint32_t interleaved(std::size_t k) const {
    return spread(of[0][k]) << 2 | spread(of[1][k]) << 1 | spread(of[2][k]);
  }
};

/// Makes of cells of a cube of 1024³ what interleaved() turns into their places along the Hilbert curve
/// through it, which never jumps: neighbours along it are neighbours in space. Source: Skilling, Programming
/// the Hilbert curve (2004), without its branches, which no processor foresees.
void turn_to_hilbert_curve(Cells& x) {
  for (std::uint32_t bit = 9; bit > 0; --bit) {
    const std::uint32_t below = (1u << bit) - 1u;
    for (std::uint32_t(&axis)[batch] : x.of)
      for (std::size_t k = 0; k < batch; ++k) {
        const std::uint32_t turns = 0u - (axis[k] >> bit & 1u);
        const std::uint32_t swapped = (x.of[0][k] ^ axis[k]) & below & ~turns;
        axis[k] ^= swapped;
        x.of[0][k] ^= swapped | (below & turns);
      }
  }
  for (std::size_t k = 0; k < batch; ++k) {
    x.of[1][k] ^= x.of[0][k];
    x.of[2][k] ^= x.of[1][k];
    // Of each bit, whether those above it are odd in number.
    std::uint32_t turned = x.of[2][k] >> 1;
    turned ^= turned >> 1;
    turned ^= turned >> 2;
    turned ^= turned >> 4;
    turned ^= turned >> 8;
    for (std::uint32_t(&axis)[batch] : x.of) axis[k] ^= turned;
  }
}

/// A point's cell, its place in it, and its index.
struct Entry {
  std::uint32_t cell, within, index;
};

struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
};

/// By cells, least significant digit first, in three digits of 10 bits: equal ones keep their order.
void sort_by_cells(UnsetArray<Entry>& entries) {
  constexpr std::size_t digits = 1024, run = 1 << 17;
  const std::size_t runs = (entries.size() + run - 1) / run;
  UnsetArray<Entry> other(entries.size());
  std::vector<std::array<std::uint32_t, digits>> starts(runs);
  for (int shift = 0; shift < 30; shift += 10) {
    const auto of_run = [&](std::size_t r, const auto& visit) {
      const std::size_t end = std::min((r + 1) * run, entries.size());
      for (std::size_t i = r * run; i < end; ++i) visit(entries[i], entries[i].cell >> shift & (digits - 1));
    };
    parallel_for_each_index(runs, [&](std::size_t r) {
      starts[r].fill(0);
      of_run(r, [&](const Entry&, std::size_t digit) { ++starts[r][digit]; });
    });
    std::uint32_t next = 0;
    for (std::size_t digit = 0; digit < digits; ++digit)
      for (std::size_t r = 0; r < runs; ++r) next += std::exchange(starts[r][digit], next);
    parallel_for_each_index(runs, [&](std::size_t r) {
      of_run(r, [&](const Entry& entry, std::size_t digit) { other[starts[r][digit]++] = entry; });
    });
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
  UnsetArray<Entry> entries(count);
  constexpr double most = 1024.0 * 1024.0 - 1.0;
  const double per_unit = widest > 0.0 ? most / widest : 0.0;
  // Of cells that are too small for a number all are one.
  const double scale = std::isfinite(per_unit) ? per_unit : 0.0;
  parallel_for_each_index((count + batch - 1) / batch, [&, low = low](std::size_t b) {
    const std::size_t first = b * batch, size = std::min(batch, count - first);
    Cells coarse{}, within{};
    for (std::size_t k = 0; k < size; ++k) {
      const Eigen::Vector3d at = position(first + k);
      for (int axis = 0; axis < 3; ++axis) {
        const auto place =
            static_cast<std::uint32_t>(std::min(most, (0.5 * at[axis] - 0.5 * low[axis]) * scale));
        coarse.of[axis][k] = place >> 10;
        within.of[axis][k] = place & 1023u;
      }
    }
    turn_to_hilbert_curve(coarse);
    for (std::size_t k = 0; k < size; ++k)
      entries[first + k] = {coarse.interleaved(k), within.interleaved(k),
                            static_cast<std::uint32_t>(first + k)};
  });
  sort_by_cells(entries);
  const auto before = [&](const Entry& a, const Entry& b) {
    return a.within != b.within ? a.within < b.within : less(a.index, b.index);
  };
  constexpr std::size_t run = 1 << 14;
  const std::size_t runs = (count + run - 1) / run;
  std::vector<std::size_t> starts(runs + 1, count);  // of the first cell that begins in each
  parallel_for_each_index(runs, [&](std::size_t r) {
    std::size_t i = r * run;
    while (i > 0 && i < count && entries[i].cell == entries[i - 1].cell) ++i;
    starts[r] = i;
  });
  std::vector<std::uint32_t> order(count);
  parallel_for_each_index(runs, [&](std::size_t r) {
    for (std::size_t first = starts[r]; first < starts[r + 1];) {
      std::size_t last = first + 1;
      while (last < starts[r + 1] && entries[last].cell == entries[first].cell) ++last;
      if (last - first > 1)
        std::sort(entries.begin() + static_cast<std::ptrdiff_t>(first),
                  entries.begin() + static_cast<std::ptrdiff_t>(last), before);
      for (; first < last; ++first) order[first] = entries[first].index;
    }
  });
  return order;
}

}  // namespace swept
