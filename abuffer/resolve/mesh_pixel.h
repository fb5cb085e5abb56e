// A pixel in which a mesh is seen among others, or among discs: surfaces of each, place by place, over one
// another by their depth. Source: model section 15.3 and 15.4.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "abuffer/resolve/depth_changes.h"
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
  /// What a place sees of a mesh: pieces of view_.
  struct Track {
    std::uint32_t mesh;
    std::size_t place;
    std::size_t next, last;
  };
  /// What a place adds to a surface.
  struct Part {
    std::size_t place;
    std::uint32_t layer;  ///< of view_
    double weight;        ///< of its depth in that of the surface; where colours do not change
  };
  /// Between two events: what the places of a pixel meet of one mesh as their k-th, or of discs.
  struct Surface {
    double depth = 0.0;
    double rgba[4] = {0.0, 0.0, 0.0, 0.0};
    std::uint32_t owner = 0;                ///< mesh, or of_discs
    std::size_t first = 0, count = 0;       ///< of parts_
    float nearest = 0.0f, farthest = 0.0f;  ///< all the time
    bool opaque = false;                    ///< all the time, at all places at which light is left
  };
  /// Of two surfaces, which may change places.
  struct Pair {
    std::size_t a, b;
    double values[DepthChanges::places.size()], depth;
  };
  static constexpr std::uint32_t of_discs = ~0u;

  void list_surfaces();
  void list_mesh(std::size_t first, std::size_t last);
  void list_discs();
  void color_plain(Surface& surface, double (&light)[pixel_places]);
  [[nodiscard]] double depth_of(const Surface& surface, double time);
  /// Looks at all surfaces at that time.
  void look(double time);
  void look_at_mesh(std::size_t first, std::size_t last, double time);
  /// Fills order_ with those that are not clear, as they were last looked at, from the nearest on.
  void put_in_order();
  [[nodiscard]] LightSum light_at(double time);
  void find_changes(double begin, double end);
  void add_plain(double begin, double end, LightSum& sum);
  void add_smooth(double begin, double end, LightSum& sum);
  void add_depths(double first, double last);
  void add_between_events(double begin, double end, LightSum& sum);

  const std::vector<TriangleStretch>* triangles_ = nullptr;
  const PlaceRays* rays_ = nullptr;
  const LightOverTime* light_ = nullptr;
  PlaceSweep* sweep_ = nullptr;
  DepthSum* by_depth_ = nullptr;
  bool plain_ = false;  ///< no triangle changes its colour from place to place
  float nearest_ = 0.0f;
  const SurfaceModel* model_ = nullptr;
  PlaceView view_;
  std::vector<Track> tracks_;
  std::vector<std::size_t> on_;  ///< tracks, by mesh
  std::vector<Part> parts_;
  std::vector<Surface> surfaces_;  ///< of each mesh front to back, then of discs
  std::size_t of_meshes_ = 0;      ///< how many of them
  std::vector<std::size_t> order_, among_discs_;
  std::vector<Pair> pairs_;
  std::vector<double> times_, cuts_, changes_, begins_, ends_;
  std::size_t next_time_ = 0;  ///< of times_: none before it is later than what was added
  // Of add():
  std::span<const MovingSurface> discs_;
  double first_share_ = 0.0, last_share_ = 1.0;  ///< of the light of the row
};

}  // namespace swept
