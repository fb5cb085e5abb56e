// What one place of a pixel sees of a mesh over the exposure: intervals in (time, depth), cut wherever what
// is seen changes. Source: Rönnow et al. 2021, section 4.2; Gribel et al. 2013, section 5.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "abuffer/resolve/place_depth.h"
#include "abuffer/sources/triangle_stretch.h"

namespace swept {

/// Light over time for the rows of a film: shutter time as triangles have it, evenly over the exposure of all
/// rows, and the share of the light of a row that is in.
class LightOverTime {
 public:
  LightOverTime(const Exposure& all, const Exposure& row)
      : even_(!row.curve && row.open == all.open && row.close == all.close), all_(all), row_(row) {
    if (even_) return;
    from_ = (row.open - all.open) / (all.close - all.open);
    to_ = (row.close - all.open) / (all.close - all.open);
  }
  /// Time and share are the same.
  [[nodiscard]] bool even() const { return even_; }
  /// When the row is exposed.
  [[nodiscard]] double from() const { return from_; }
  [[nodiscard]] double to() const { return to_; }
  [[nodiscard]] double share(double time) const {
    if (even_) return time;
    return std::clamp(row_.share_at(all_.open + time * (all_.close - all_.open)), 0.0, 1.0);
  }
  [[nodiscard]] double time(double share) const {
    if (even_) return share;
    return (row_.at(share) - all_.open) / (all_.close - all_.open);
  }

 private:
  bool even_;
  Exposure all_, row_;
  double from_ = 0.0, to_ = 1.0;
};

/// An interval of a place, as what is made of it knows it.
struct PlaceLayer {
  double begin, end;
  float nearest, farthest;
  std::uint32_t source;  ///< of the TriangleStretch
  static constexpr std::uint32_t none = ~0u;
  std::uint32_t depth = none;  ///< of PlaceView::depths
  float least_alpha = 0.0f;    ///< of the triangle
  bool opaque = false;
  bool near = false;  ///< not behind what hides it, in the piece before
  // For who adds its light: with what weight it is seen, from when, and up to when at least.
  double weight = 0.0, from = 0.0, until = 0.0;
};

/// A stretch of time in which one place sees the same triangles in the same order.
struct PlacePiece {
  double begin, end;
  std::uint32_t first, count;  ///< of PlaceView::seen, from the nearest on
};

/// What places see.
struct PlaceView {
  std::vector<PlacePiece> pieces;
  std::vector<std::uint32_t> seen;  ///< indices of layers
  std::vector<PlaceLayer> layers;
  std::vector<PlaceDepth> depths;

  void clear() {
    pieces.clear();
    seen.clear();
    layers.clear();
    depths.clear();
  }
  /// Made when it is first asked for.
  [[nodiscard]] const PlaceDepth& depth(std::uint32_t layer, const std::vector<TriangleStretch>& triangles,
                                        const Eigen::Vector3d& ray) {
    PlaceLayer& of = layers[layer];
    if (of.depth == PlaceLayer::none) {
      of.depth = static_cast<std::uint32_t>(depths.size());
      depths.emplace_back(triangles[of.source], ray, of.nearest, of.farthest);
    }
    return depths[of.depth];
  }
};

struct PlaceCounters {
  std::uint64_t pieces = 0, crossings = 0;
  void add(const PlaceCounters& o) { pieces += o.pieces, crossings += o.crossings; }
};

/// A thread's.
class PlaceSweep {
 public:
  /// Appends what one place sees of its intervals, which it puts in order. Where nothing is seen there is no
  /// piece. What lies behind an opaque triangle, or where no light is left, is left out.
  void cut(std::span<PlaceInterval> intervals, const std::vector<TriangleStretch>& triangles,
           const Eigen::Vector3d& ray, PlaceView& view);

  PlaceCounters counters;
  /// A pixel may take seconds: what finds surfaces of it throws Stopped once this asks for it.
  std::stop_token stop;

 private:
  void find_near(double begin);
  void find_crossings(double begin);
  void order(double time, bool crossed);
  [[nodiscard]] const PlaceDepth& depth(std::uint32_t layer) {
    return view_->depth(layer, *triangles_, *ray_);
  }
  void see(double begin, double end);

  const std::vector<TriangleStretch>* triangles_ = nullptr;
  const Eigen::Vector3d* ray_ = nullptr;
  PlaceView* view_ = nullptr;
  std::size_t first_piece_ = 0;
  std::vector<std::uint32_t> active_;  ///< layers that are there
  std::vector<std::uint32_t> near_,
      new_;                        ///< of them, those that may be seen, in order; and those to be put in
  std::vector<double> crossings_;  ///< a heap, the next one first
};

}  // namespace swept
