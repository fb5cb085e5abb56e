// A pixel in which several meshes are seen: surfaces of each, place by place, over one another by their
// depth. Source: model section 15.3 and 15.4.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "abuffer/resolve/place_light.h"
#include "splat/interval/pixel_places.h"

namespace swept {

using PlaceRays = std::array<Eigen::Vector3d, pixel_places>;

/// A thread's.
class MeshPixel {
 public:
  /// `intervals` of all places and meshes, by place and within it by source. Adds to `sum`.
  void resolve(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
               const PlaceRays& rays, const LightOverTime& light, PlaceSweep& sweep, LightSum& sum);

 private:
  struct Track {
    std::uint32_t mesh;
    std::size_t place;
    std::vector<PlacePiece> pieces;
    std::vector<std::uint32_t> seen;
    std::size_t next = 0;
  };
  struct Surface {
    double depth;
    double rgba[4];
    std::uint32_t mesh, layer;
  };
  using Order = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

  /// Fills surfaces_, from the nearest on, of the pieces that are on at `time`.
  void look(double time);
  [[nodiscard]] LightSum light_at(double time);
  [[nodiscard]] Order order_at(double time);
  void mesh_surfaces(std::size_t first, std::size_t last, double time);

  const std::vector<TriangleStretch>* triangles_ = nullptr;
  const PlaceRays* rays_ = nullptr;
  std::vector<Track> tracks_;
  std::vector<std::size_t> on_;  ///< tracks, by mesh
  std::vector<Surface> surfaces_;
  std::vector<double> times_;
};

}  // namespace swept
