// What the stochastic method draws of a scene.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "abuffer/stochastic/mesh_paths.h"
#include "abuffer/stochastic/moving_disc.h"
#include "abuffer/stochastic/moving_triangle.h"
#include "splat/kernel/kernel_set.h"
#include "splat/scene.h"
#include "splat/without_throwing.h"

namespace swept::stochastic {

/// Discs and triangles of a scene, in one row: discs first.
class Primitives {
 public:
  /// `view` must outlive them. Error: an object that cannot be followed. Throws Stopped.
  [[nodiscard]] static Result<Primitives> of(const Scene& scene, const Exposure& exposure,
                                             const FilmView& view, const std::stop_token& stop) {
    Primitives all(view, scene.model.delta);
    if (std::any_of(scene.objects.begin(), scene.objects.end(),
                    [](const Object& o) { return o.discs() > 0; }))
      all.kernels_ = build_kernels(scene, exposure, stop);
    throw_if_stopped(stop);
    all.begins_.push_back(all.kernels_.kernels.size());
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      const Object& object = scene.objects[i];
      if (object.triangles.empty()) continue;
      Result<MeshPaths> paths = MeshPaths::follow(scene, object, exposure, stop);
      if (!paths) {
        Error error = paths.error();
        error.field = "/objects/" + std::to_string(i);
        return error;
      }
      all.meshes_.push_back(std::make_unique<MeshPaths>(*std::move(paths)));
      all.begins_.push_back(all.begins_.back() + object.triangles.size());
    }
    return all;
  }

  [[nodiscard]] std::size_t size() const { return begins_.back(); }
  /// What all of them take.
  [[nodiscard]] std::size_t bytes() const {
    std::size_t bytes = kernels_.kernels.size() * sizeof(MovingKernel);
    for (const auto& mesh : meshes_) bytes += mesh->bytes();
    return bytes;
  }
  [[nodiscard]] const KernelSet& kernels() const { return kernels_; }
  [[nodiscard]] const FilmView& view() const { return view_; }
  [[nodiscard]] std::size_t meshes() const { return meshes_.size(); }
  [[nodiscard]] const MeshPaths& mesh(std::size_t i) const { return *meshes_[i]; }
  /// Where a mesh's triangles begin in the row.
  [[nodiscard]] std::size_t begin_of(std::size_t mesh) const { return begins_[mesh]; }

  /// visit(primitive), which is a disc or a triangle.
  template <class Visit>
  void with(std::size_t i, const Visit& visit) const {
    if (i < begins_.front()) {
      MovingDisc disc(kernels_.kernels[i], delta_, view_);
      if (disc.exists()) visit(disc);
      return;
    }
    std::size_t mesh = 0;
    while (i >= begins_[mesh + 1]) ++mesh;
    MovingTriangle triangle(*meshes_[mesh], static_cast<std::uint32_t>(i - begins_[mesh]), view_);
    visit(triangle);
  }

 private:
  Primitives(const FilmView& view, double delta) : view_(view), delta_(delta) {}

  const FilmView& view_;
  double delta_;
  KernelSet kernels_;
  std::vector<std::unique_ptr<MeshPaths>> meshes_;
  std::vector<std::size_t> begins_;
};

}  // namespace swept::stochastic
