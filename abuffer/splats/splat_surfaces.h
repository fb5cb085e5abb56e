// The discs of a scene that has splats too: their surfaces in each cell at each instant.
#pragma once

#include <span>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "abuffer/resolve/sample_plan.h"
#include "abuffer/resolve/sampled_cell.h"
#include "abuffer/simd/sampled_math.h"
#include "abuffer/sources/object_instant.h"
#include "abuffer/sources/point_packets.h"
#include "abuffer/tiles/cells.h"

namespace swept {

class SplatSurfaces {
 public:
  SplatSurfaces(const Scene& scene, const Exposure& exposure, bool only_standing, std::size_t implementation)
      : scene_(scene),
        exposure_(exposure),
        objects_(pack_points(scene, exposure, only_standing)),
        bins_(scene, exposure, objects_),
        cells_([this, implementation] {
          return SampledCell(scene_, objects_, sampled_maths().first[implementation]);
        }) {}
  // cells_ refers to it.
  SplatSurfaces(const SplatSurfaces&) = delete;
  SplatSurfaces& operator=(const SplatSurfaces&) = delete;

  [[nodiscard]] bool empty() const { return objects_.empty(); }
  /// Motion across a cell, px; 0 only where everything stands still.
  [[nodiscard]] float motion_px(std::size_t cell) const {
    return empty() || exposure_.instant() ? 0.0f : typical_motion(bins_, bins_.packets(cell));
  }
  [[nodiscard]] std::vector<ObjectInstant> at(double time) const {
    std::vector<ObjectInstant> instants;
    for (const PointPackets& object : objects_) instants.emplace_back(scene_, object, exposure_.at(time));
    return instants;
  }
  /// The thread's, begun; nothing where no disc comes by the cell.
  [[nodiscard]] SampledCell* begin(std::size_t cell) {
    if (empty() || bins_.packets(cell).empty()) return nullptr;
    SampledCell& local = cells_.local();
    local.begin(bins_.cell(cell), bins_.packets(cell));
    return &local;
  }
  [[nodiscard]] std::size_t discs() const {
    std::size_t count = 0;
    for (const PointPackets& object : objects_) count += object.object->cloud.size();
    return count;
  }

 private:
  const Scene& scene_;
  Exposure exposure_;
  std::vector<PointPackets> objects_;
  PacketBins bins_;
  tbb::enumerable_thread_specific<SampledCell> cells_;
};

}  // namespace swept
