// How far the triangles that come by each cell of the film move over the exposure.
#pragma once

#include <vector>

#include "abuffer/sources/mesh_instant.h"
#include "abuffer/tiles/cells.h"
#include "splat/scene.h"

namespace swept {

class MeshMotion {
 public:
  /// Follows every triangle of every mesh.
  MeshMotion(const Scene& scene, const Exposure& exposure, const CellGrid& grid);

  /// The root mean square over those that move and come by at any time of the exposure, px; 0 only where none
  /// does.
  [[nodiscard]] float px(std::size_t cell) const;

 private:
  void follow(const Scene& scene, const Object& object, const Exposure& exposure, const CellGrid& grid);

  std::vector<double> squares_, count_;  ///< of the cells
};

}  // namespace swept
