// Points that pass by a cell, packed for it alone, where packets come apart: of sixteen points that fly their
// own ways few pass by any one cell, and all would be placed in each.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "abuffer/sources/point_packets.h"
#include "abuffer/tiles/cells.h"
#include "splat/scene.h"

namespace swept {

/// What is drawn in a cell. `refs` are of `objects`, some of which may be `own`.
struct CellPackets {
  std::vector<PacketRef> refs;
  std::vector<const PointPackets*> objects;
  std::vector<PointPackets> own;
};

class PointLists {
 public:
  /// Follows by themselves the points of objects whose packets touch far more cells than each of their points
  /// can. Runs in the caller's task arena. All arguments must outlive it.
  PointLists(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects,
             const PacketBins& bins);

  /// Packets of a cell: those of its bin, or in place of an object's the points that may pass by, in the same
  /// order, where these are packets enough less. Nothing where they are nowhere.
  [[nodiscard]] std::optional<CellPackets> of(std::size_t cell) const;

 private:
  const std::vector<PointPackets>& objects_;
  const PacketBins& bins_;
  std::vector<std::size_t> followed_;  ///< objects
  std::vector<PointPackets>
      points_;  ///< of each of these, a packet a point: where it goes, and how large it is
  std::optional<PacketBins> passing_;
};

}  // namespace swept
