// The surfaces of discs and meshes in a pixel at one instant, for a picture that has splats between them.
#pragma once

#include <optional>
#include <vector>

#include "abuffer/reference/mesh_reference.h"
#include "abuffer/reference/posed_scene.h"
#include "abuffer/reference/reference_frame.h"
#include "splat/kernel/kernel_set.h"

namespace swept::reference {

/// Discs and meshes of a scene along their true paths.
class SurfacesAt {
 public:
  /// `scene` must outlive it.
  explicit SurfacesAt(const Scene& scene);

  [[nodiscard]] bool any() const { return any_discs_ || any_meshes_; }
  void move_to(double frame);
  /// What pixel (x, y) of the film shows of them, the first in front.
  [[nodiscard]] std::vector<Surface> of_pixel(int x, int y) const;

 private:
  const Scene& scene_;
  bool any_discs_ = false, any_meshes_ = false;
  PixelBox window_;
  std::optional<PosedScene> posed_;
  KernelSet kernels_;
  std::vector<Disc> discs_;
  std::vector<MeshAt> meshes_;
};

}  // namespace swept::reference
