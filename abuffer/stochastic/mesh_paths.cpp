#include "abuffer/stochastic/mesh_paths.h"

#include <algorithm>

#include "abuffer/sources/moving_mesh.h"

namespace swept::stochastic {

MeshPaths::MeshPaths(const Object& object, const Exposure& exposure)
    : object_(&object), open_(exposure.open), close_(exposure.close) {
  if (!object.cloud.looks.empty()) opaque_looks_ = !object.cloud.see_through();
  const auto look_through = [&](const std::shared_ptr<const Texture>& texture) {
    if (texture)
      for (const Eigen::Vector4f& texel : texture->texels) opaque_looks_ = opaque_looks_ && texel.w() >= 1.0f;
  };
  look_through(object.texture);
  for (const Material& material : object.materials) {
    look_through(material.texture);
    opaque_looks_ = opaque_looks_ && material.opacity >= 1.0f;
  }
}

Result<MeshPaths> MeshPaths::follow(const Scene& scene, const Object& object, const Exposure& exposure,
                                    const std::stop_token& stop) {
  // The shutter's curve says when samples look, and not how things move.
  const Exposure even{exposure.open, exposure.close};
  const double widest = std::max(path_tangent, film_tangent(scene, even));
  const Result<MovingMesh> mesh = MovingMesh::follow(scene, object, even, path_tolerance_px, 2, widest, stop);
  if (!mesh) return mesh.error();

  MeshPaths paths(object, exposure);
  const std::size_t count = object.cloud.size(), pieces = mesh->stretches();
  for (std::size_t p = 0; p <= pieces; ++p) paths.cuts_.push_back(mesh->time(p));
  paths.mirrored_ = mesh->mirrored(static_cast<std::size_t>(paths.piece_of(0.5)));
  paths.stride_ = 2 * pieces + 1;
  paths.controls_.resize(count * paths.stride_);
  const Projection film = projection_of(scene.film, scene.camera.at(exposure.middle()));
  double bend = 0.0;
  for (std::size_t p = 0; p < pieces; ++p)
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d* const path = mesh->path(p, i);
      Eigen::Vector3d* const control = &paths.controls_[i * paths.stride_ + 2 * p];
      const Eigen::Vector3d &begin = path[0], &end = path[mesh->degree()], chord = 0.5 * (begin + end);
      control[0] = begin;
      control[1] = mesh->degree() == 2 ? path[1] : chord;
      control[2] = end;
      bend = std::max(bend, off_path_px(chord, 0.5 * (chord + control[1]), film, scene.camera.near, widest));
    }
  constexpr double none = 1e-9;  // px
  paths.degree_ = bend > none ? 2 : 1;
  if (paths.degree_ == 1)  // and no rest of it, so that bounds by the ends alone hold
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t p = 0; p + 2 < paths.stride_; p += 2) {
        Eigen::Vector3d* const control = &paths.controls_[i * paths.stride_ + p];
        control[1] = 0.5 * (control[0] + control[2]);
      }
  return paths;
}

}  // namespace swept::stochastic
