// How far out of focus packets of points are. For the project's own sources.
#pragma once

#include <span>
#include <vector>

#include "abuffer/sources/point_packets.h"
#include "abuffer/tiles/cells.h"
#include "splat/exposure.h"
#include "splat/scene.h"

namespace swept {

/// Circles of confusion, in pixels across, in the middle of the exposure.
class PacketBlur {
 public:
  /// Of a scene with a lens. `objects` are those of pack_points().
  PacketBlur(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects);

  /// The one that stands for all of these; 0: there are none.
  [[nodiscard]] double of(std::span<const PacketRef> packets) const;

 private:
  std::vector<std::vector<float>> px_;  ///< by object and packet
};

}  // namespace swept
