// A pixel in which a mesh is seen among others, or among discs: surfaces of each, place by place, over one
// another by their depth. Source: model section 15.3 and 15.4.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "abuffer/resolve/moving_surface.h"
#include "abuffer/resolve/place_light.h"
#include "splat/interval/pixel_places.h"

namespace swept {

using PlaceRays = std::array<Eigen::Vector3d, pixel_places>;

/// A thread's.
class MeshPixel {
 public:
  /// Of a pixel: `intervals` of all places and meshes, which it sorts. All it is given must outlive what is
  /// done with the pixel. Where there is a `by_depth` it gathers what is added, too.
  void begin(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
             const PlaceRays& rays, const LightOverTime& light, PlaceSweep& sweep,
             DepthSum* by_depth = nullptr);
  /// Nothing of it is nearer.
  [[nodiscard]] float nearest() const { return nearest_; }
  /// When any of it begins, ends or changes; increasing.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  /// Adds what is seen from one time to another, among discs that have these surfaces over just that time,
  /// front to back. Calls go on where the one before ended, or later.
  void add(double from, double to, std::span<const MovingSurface> discs, const SurfaceModel& model,
           LightSum& sum);
  void add(double from, double to, LightSum& sum);

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
  static constexpr std::uint32_t of_discs = ~0u;  ///< for a mesh's number
  using Order = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

  /// Fills surfaces_, from the nearest on, of the pieces that are on at `time`.
  void look(double time);
  [[nodiscard]] LightSum light_at(double time);
  [[nodiscard]] Order order_at(double time);
  void mesh_surfaces(std::size_t first, std::size_t last, double time);
  void merge_discs(double time);
  void add_between_events(double begin, double end, LightSum& sum);
  void add_depths(double first, double last);

  const std::vector<TriangleStretch>* triangles_ = nullptr;
  const PlaceRays* rays_ = nullptr;
  const LightOverTime* light_ = nullptr;
  PlaceSweep* sweep_ = nullptr;
  DepthSum* by_depth_ = nullptr;
  bool plain_ = false;  ///< no triangle changes its colour from place to place
  float nearest_ = 0.0f;
  const SurfaceModel* model_ = nullptr;
  std::vector<Track> tracks_;
  std::vector<std::size_t> on_;  ///< tracks, by mesh
  std::vector<Surface> surfaces_, merged_, as_begins_, as_ends_;
  std::vector<double> times_, cuts_;
  std::size_t next_time_ = 0;  ///< of times_: none before it is later than what was added
  // Of add():
  std::span<const MovingSurface> discs_;
  double first_share_ = 0.0, last_share_ = 1.0;  ///< of the light of the row
};

}  // namespace swept
