#include "abuffer/splats/splat_row.h"

#include <array>
#include <bit>

#include "abuffer/parallel.h"
#include "abuffer/splats/posed_packet.h"

namespace swept {
namespace {

/// Packets that one thread places before it takes more.
constexpr std::size_t packets_a_run = 128;

/// Cells [first, last] of one side.
struct CellRange {
  std::size_t x_first, x_last, y_first, y_last;

  explicit CellRange(const PlacedSplat& s)
      : x_first(s.x_first / static_cast<unsigned>(cell_px)),
        x_last(s.x_last / static_cast<unsigned>(cell_px)),
        y_first(s.y_first / static_cast<unsigned>(cell_px)),
        y_last(s.y_last / static_cast<unsigned>(cell_px)) {}

  template <class Visit>
  void for_each(std::size_t columns, const Visit& visit) const {
    for (std::size_t y = y_first; y <= y_last; ++y)
      for (std::size_t x = x_first; x <= x_last; ++x) visit(y * columns + x);
  }
};

}  // namespace

std::vector<std::uint32_t> by_depth(const std::vector<PlacedSplat>& splats) {
  // Depths are positive: their bits are in their order. Least significant digit first, three of 11 bits.
  constexpr std::size_t digits = 2048;
  struct Entry {
    std::uint32_t key, index;
  };
  std::vector<Entry> entries(splats.size()), other(splats.size());
  std::array<std::array<std::uint32_t, digits + 1>, 3> starts{};
  for (std::size_t i = 0; i < splats.size(); ++i) {
    const auto key = std::bit_cast<std::uint32_t>(splats[i].depth);
    entries[i] = {key, static_cast<std::uint32_t>(i)};
    for (std::size_t d = 0; d < 3; ++d) ++starts[d][((key >> (11 * d)) & (digits - 1)) + 1];
  }
  for (std::size_t d = 0; d < 3; ++d) {
    for (std::size_t i = 0; i < digits; ++i) starts[d][i + 1] += starts[d][i];
    for (const Entry& entry : entries) other[starts[d][(entry.key >> (11 * d)) & (digits - 1)]++] = entry;
    entries.swap(other);
  }
  std::vector<std::uint32_t> order(splats.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = entries[i].index;
  return order;
}

SplatRow::SplatRow(const Scene& scene, const std::vector<SplatPackets>& sets, bool moving, double frame,
                   const SplatMath& math, const CellGrid& grid, const std::vector<char>& wanted) {
  place(scene, sets, moving, frame, math);
  share_out(grid, wanted);
}

void SplatRow::place(const Scene& scene, const std::vector<SplatPackets>& sets, bool moving, double frame,
                     const SplatMath& math) {
  for (const SplatPackets& set : sets) {
    if (set.moves != moving) continue;
    const SplatPose pose(scene, set, frame);
    const std::size_t runs = (set.count + packets_a_run - 1) / packets_a_run;
    std::vector<std::vector<PlacedSplat>> placed(runs);
    parallel_for_each_index(runs, [&](std::size_t r) {
      const std::size_t begin = r * packets_a_run, end = std::min(begin + packets_a_run, set.count);
      std::vector<PlacedSplat>& own = placed[r];
      own.resize((end - begin) * static_cast<std::size_t>(packet_size));
      PlacedSplat* to = own.data();
      PosedPacket memory;
      for (std::size_t p = begin; p < end; ++p)
        to += std::popcount(math.place(fields_at(set, p, pose, memory), pose.view, pose.origin(set, p), to));
      own.resize(static_cast<std::size_t>(to - own.data()));
    });
    const std::size_t first = splats_.size();
    for (const std::vector<PlacedSplat>& own : placed) splats_.insert(splats_.end(), own.begin(), own.end());
    if (set.object->splats.flat) {
      discs_.push_back(first);
      discs_.push_back(splats_.size());
    }
  }
}

bool SplatRow::is_disc(std::size_t splat) const {
  for (std::size_t i = 0; i < discs_.size(); i += 2)
    if (splat >= discs_[i] && splat < discs_[i + 1]) return true;
  return false;
}

void SplatRow::share_out(const CellGrid& grid, const std::vector<char>& wanted) {
  starts_.assign(grid.size() + 1, 0);
  for (const PlacedSplat& splat : splats_)
    CellRange(splat).for_each(grid.columns, [&](std::size_t cell) {
      if (wanted[cell]) ++starts_[cell + 1];
    });
  for (std::size_t cell = 0; cell < grid.size(); ++cell) starts_[cell + 1] += starts_[cell];
  entries_.resize(starts_.back());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (const std::uint32_t index : by_depth(splats_)) {
    const bool disc = is_disc(index);
    CellRange(splats_[index]).for_each(grid.columns, [&](std::size_t cell) {
      if (wanted[cell]) entries_[next[cell]++] = disc ? index | disc_flag : index;
    });
  }
}

}  // namespace swept
