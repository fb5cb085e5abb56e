// Splats placed at one instant, sorted once by depth, and which of them come by in each cell of the film.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "abuffer/simd/splat_math.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/tiles/cells.h"

namespace swept {

/// Indices of splats from the nearest to the farthest; of equal depths in their order.
[[nodiscard]] std::vector<std::uint32_t> by_depth(const std::vector<PlacedSplat>& splats);

class SplatRow {
 public:
  SplatRow() = default;
  /// Those sets of `sets` that move, or those that do not, at `frame`. Of the cells only those `wanted` are
  /// filled. Runs in the caller's task arena.
  SplatRow(const Scene& scene, const std::vector<SplatPackets>& sets, bool moving, double frame,
           const SplatMath& math, const CellGrid& grid, const std::vector<char>& wanted);

  [[nodiscard]] const PlacedSplat* splats() const { return splats_.data(); }
  [[nodiscard]] std::size_t size() const { return splats_.size(); }
  [[nodiscard]] bool is_disc(std::size_t splat) const;
  /// Of a cell, nearest first: indices into splats(), some with disc_flag.
  [[nodiscard]] std::span<const std::uint32_t> cell(std::size_t index) const {
    if (starts_.empty()) return {};
    return std::span(entries_).subspan(starts_[index], starts_[index + 1] - starts_[index]);
  }

 private:
  void place(const Scene& scene, const std::vector<SplatPackets>& sets, bool moving, double frame,
             const SplatMath& math);
  void share_out(const CellGrid& grid, const std::vector<char>& wanted);

  std::vector<PlacedSplat> splats_;
  std::vector<std::size_t> discs_;  ///< where runs of discs begin and end
  std::vector<std::size_t> starts_;
  std::vector<std::uint32_t> entries_;
};

}  // namespace swept
