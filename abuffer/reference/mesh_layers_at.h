// What the layers show of a pixel of meshes (model section 13), the plain way: each place's ray meets every
// triangle in world space. Shares nothing with abuffer/mesh_layers.h.
#pragma once

#include <Eigen/Core>

#include "splat/scene.h"

namespace swept::reference {

/// As render_layers() has it; 0 where there is no surface.
struct LayersOfPixel {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();                                       ///< world space
  Eigen::Vector2d forward = Eigen::Vector2d::Zero(), backward = Eigen::Vector2d::Zero();  ///< px per frame
  double coverage = 0.0;
};

/// Of a valid scene of meshes alone; the film's pixel (x, y).
[[nodiscard]] LayersOfPixel mesh_layers_at(const Scene& scene, int x, int y);

}  // namespace swept::reference
