// The film in cells of 64 × 64 pixels, or of 64 × 1 where each row is exposed at a time of its own, and which
// packets of points come by in each.
//
// Cells are of the film, not of the crop: what is decided for one does not depend on what else is asked for.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "abuffer/sources/object_instant.h"
#include "abuffer/sources/point_packets.h"
#include "splat/scene.h"

namespace swept {

struct Cell {
  int x = 0, y = 0, width = 0, height = 0;  ///< px of the film
};

/// The film's cells, in rows.
struct CellGrid {
  Film film;
  std::size_t columns, rows;

  explicit CellGrid(const Film& of)
      : film(of),
        columns(static_cast<std::size_t>((of.width + cell_px - 1) / cell_px)),
        rows(static_cast<std::size_t>((of.height + cell_px - 1) / cell_px)) {}
  [[nodiscard]] std::size_t size() const { return columns * rows; }
  [[nodiscard]] Cell cell(std::size_t index) const {
    const int x = static_cast<int>(index % columns) * cell_px,
              y = static_cast<int>(index / columns) * cell_px;
    return {x, y, std::min(cell_px, film.width - x), std::min(cell_px, film.height - y)};
  }
};

/// A packet of one of the objects.
struct PacketRef {
  std::uint32_t object, packet;
};

class PacketBins {
 public:
  /// Follows every packet over the exposure, of all rows. Runs in the caller's task arena.
  PacketBins(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects);

  [[nodiscard]] std::size_t cell_count() const { return starts_.size() - 1; }
  [[nodiscard]] Cell cell(std::size_t index) const;
  /// Packets that may touch a cell at any time of the exposure, in the order of the objects and their
  /// packets.
  [[nodiscard]] std::span<const PacketRef> packets(std::size_t cell) const {
    return std::span(entries_).subspan(starts_[cell], starts_[cell + 1] - starts_[cell]);
  }
  /// How far a packet's centre moves across the film over a row's exposure, px; 0 only where it stands still.
  [[nodiscard]] float motion_px(PacketRef packet) const { return motion_[packet.object][packet.packet].px; }
  /// How many cells it may touch, of those that there are.
  [[nodiscard]] float cells_touched(PacketRef packet) const {
    return motion_[packet.object][packet.packet].cells;
  }

 private:
  void follow(const Scene& scene, const Exposure& exposure, const PointPackets& packets, std::size_t object);

  Film film_;
  int cell_height_;  ///< px
  std::size_t columns_, rows_;
  struct Motion {
    float px = 0.0f, cells = 0.0f;
  };
  std::vector<std::vector<Motion>> motion_;
  std::vector<std::size_t> starts_;
  std::vector<PacketRef> entries_;

  struct Touch {
    std::uint32_t cell;
    PacketRef packet;
  };
  std::vector<std::vector<Touch>> touched_;  ///< by runs of packets, in order
};

}  // namespace swept
