// The discs and triangles of a scene: what surfaces they show in each cell of the film at each instant.
#pragma once

#include <memory>
#include <vector>

#include "abuffer/parallel.h"
#include "abuffer/resolve/mesh_cell.h"
#include "abuffer/resolve/sampled_cell.h"
#include "abuffer/simd/sampled_math.h"
#include "abuffer/sources/mesh_instant.h"
#include "abuffer/sources/object_instant.h"
#include "abuffer/sources/point_packets.h"
#include "abuffer/tiles/cells.h"
#include "abuffer/tiles/mesh_motion.h"

namespace swept {

class FilmSurfaces {
 public:
  /// Runs in the caller's task arena.
  FilmSurfaces(const Scene& scene, const Exposure& exposure, bool only_standing, const SampledMath& math,
               const MeshMath& mesh_math, const CellGrid& grid);
  // Threads' memory refers to it.
  FilmSurfaces(const FilmSurfaces&) = delete;
  FilmSurfaces& operator=(const FilmSurfaces&) = delete;

  [[nodiscard]] bool empty() const { return discs_.empty() && meshes_.empty(); }
  /// Motion across a cell, px; 0 only where everything stands still.
  [[nodiscard]] float motion_px(std::size_t cell) const;

  /// All of them at one instant.
  struct Instant {
    std::vector<ObjectInstant> discs;
    std::vector<std::shared_ptr<const MeshInstant>> meshes;
  };
  /// At a shutter time; of the cells only those `wanted`. `pinhole`: the scene as it is seen through a point
  /// of its lens, in place of the scene itself.
  [[nodiscard]] Instant at(double time, const std::vector<char>& wanted,
                           const Scene* pinhole = nullptr) const;
  /// What an instant holds of meshes that move, about.
  [[nodiscard]] std::size_t instant_bytes() const;

  /// A thread's.
  class OfCell {
   public:
    OfCell(const FilmSurfaces& film, const SampledMath& math, const MeshMath& mesh_math)
        : film_(film), discs_(film.scene_, film.discs_, math), mesh_(mesh_math) {}
    void begin(std::size_t cell);
    /// In each pixel from the nearest to the farthest.
    const std::vector<SampledCell::Surface>& at(const Instant& instant);

   private:
    void merge(const std::vector<SampledCell::Surface>& discs);

    const FilmSurfaces& film_;
    std::size_t index_ = 0;
    Cell cell_;
    SampledCell discs_;
    bool any_discs_ = false;
    MeshCell mesh_;
    std::vector<SampledCell::Surface> meshes_, by_pixel_, merged_;
    std::vector<std::size_t> disc_ends_, mesh_ends_;  ///< by pixel
  };
  /// The thread's, begun.
  [[nodiscard]] OfCell& begin(std::size_t cell) {
    OfCell& local = cells_.local();
    local.begin(cell);
    return local;
  }

  [[nodiscard]] std::size_t discs() const;
  [[nodiscard]] std::size_t triangles() const;

 private:
  const Scene& scene_;
  Exposure exposure_;
  CellGrid grid_;
  std::vector<PointPackets> discs_;
  PacketBins bins_;
  struct Mesh {
    const Object* object;
    std::shared_ptr<const MeshInstant> standing;  ///< null: it moves
  };
  std::vector<Mesh> meshes_;
  MeshMotion mesh_motion_;
  PerThread<OfCell> cells_;
};

}  // namespace swept
