#include "abuffer/reference/surfaces_at.h"

namespace swept::reference {

SurfacesAt::SurfacesAt(const Scene& scene) : scene_(scene) {
  const Film& film = scene.film;
  window_ = {film.crop_x, film.crop_y, film.crop_x + film.window_width(), film.crop_y + film.window_height()};
  for (const Object& object : scene.objects) {
    any_discs_ = any_discs_ || object.discs() > 0;
    any_meshes_ = any_meshes_ || !object.triangles.empty();
  }
  if (any_discs_ && has_own_paths(scene)) posed_.emplace(scene);
}

void SurfacesAt::move_to(double frame) {
  // Of instants that are a frame each, every kernel stands still.
  constexpr double whenever = 0.5;
  discs_.clear();
  meshes_.clear();
  if (any_discs_) {
    kernels_ = build_kernels(posed_ ? posed_->at(frame) : scene_, {frame, frame});
    for (const MovingKernel& kernel : kernels_.kernels)
      discs_.push_back(place(kernel, whenever, kernels_.projection, kernels_.near, window_));
  }
  for (const Object& object : scene_.objects)
    if (!object.triangles.empty()) meshes_.emplace_back(scene_, object, frame);
}

std::vector<Surface> SurfacesAt::of_pixel(int x, int y) const {
  std::vector<Fragment> fragments;
  for (const Disc& disc : discs_) {
    const PixelBox& box = disc.box;
    if (x < box.x_begin || x >= box.x_end || y < box.y_begin || y >= box.y_end) continue;
    if (const auto fragment =
            meet(disc, ray_through(kernels_.projection, x, y), kernels_.near, scene_.model.delta))
      fragments.push_back(*fragment);
  }
  std::vector<Surface> of_meshes, seen;
  for (const MeshAt& mesh : meshes_) mesh.meet(x, y, of_meshes);
  find_surfaces(fragments, scene_.model, of_meshes, seen);
  return seen;
}

}  // namespace swept::reference
