// The triangles of a mesh at one instant, the plain way: every triangle meets every ray near it. Source:
// model section 15.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "abuffer/reference/reference_frame.h"

namespace swept::reference {

class MeshAt {
 public:
  /// The object's textures must outlive it.
  MeshAt(const Scene& scene, const Object& object, double frame);

  /// Appends what the mesh shows in pixel (x, y) of the film.
  void meet(int x, int y, std::vector<Surface>& surfaces) const;

 private:
  struct Corners {
    Eigen::Vector3d at[3];     ///< camera space
    Eigen::Vector4d color[3];  ///< premultiplied
    const Texture* texture;    ///< the object's, or null
    Eigen::Vector2d uv[3];     ///< on it
    PixelBox box;              ///< contains every pixel that may show it
  };

  Projection projection_;
  double near_;
  std::vector<Corners> triangles_;
  std::vector<std::vector<std::uint32_t>> of_row_;  ///< triangles, by the film's row less first_row_
  int first_row_;
};

}  // namespace swept::reference
