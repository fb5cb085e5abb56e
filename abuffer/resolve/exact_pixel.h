// A pixel of the exact method: discs, triangles, or both, each the cheapest way. For the project's own
// sources. Source: model sections 1, 4 and 15.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "abuffer/resolve/mesh_pixel.h"
#include "abuffer/resolve/place_peel.h"
#include "abuffer/resolve/still.h"
#include "abuffer/resolve/sweep.h"
#include "abuffer/resolve/texel_way.h"

namespace swept {

/// What a pixel has of discs.
struct DiscsOfPixel {
  const FragmentArrays& fragments;
  const std::vector<Shade>& shades;
  std::span<std::uint32_t> indices;  ///< of fragments; may be put into another order
  ChangingShades changes = {};
};

/// And of triangles, as MeshPixel::begin() takes it.
struct TrianglesOfPixel {
  std::span<PlaceInterval> intervals;
  const std::vector<TriangleStretch>& triangles;
  const PlaceRays& rays;
  const LightOverTime& light;
};

/// A thread's.
class ExactPixel {
 public:
  /// What is found of triangles throws Stopped once `stop` asks for it.
  ExactPixel(const SurfaceModel& model, const IntervalMath& math, std::stop_token stop)
      : model_(model), still_(model), sweep_(model, math) {
    places_.stop = std::move(stop);
  }

  /// Discs of which none moves.
  void add_still(const DiscsOfPixel& discs, PixelSum& pixel) const {
    still_.resolve(discs.fragments, discs.shades, discs.indices.data(), discs.indices.size(), pixel);
  }
  void add(const DiscsOfPixel& discs, PixelSum& pixel, SweepCounters& counters) {
    sweep_.resolve(discs.fragments, discs.shades, discs.indices.data(), discs.indices.size(), pixel, counters,
                   discs.changes);
  }
  void add(const TrianglesOfPixel& triangles, PixelSum& pixel);
  /// Both, of which neither is empty.
  void add(const DiscsOfPixel& discs, const TrianglesOfPixel& triangles, PixelSum& pixel,
           SweepCounters& counters);

  [[nodiscard]] const PlaceCounters& places() const { return places_.counters; }
  std::uint64_t pixels_of_several_meshes = 0;

 private:
  void add_one_mesh(const TrianglesOfPixel& triangles, LightSum& sum, DepthSum* by_depth);
  void add_place(const TrianglesOfPixel& triangles, const Eigen::Vector3d& ray, LightSum& sum,
                 DepthSum* by_depth);
  void add_even(const TrianglesOfPixel& triangles, const Eigen::Vector3d& ray, const PlacePiece& piece,
                LightSum& sum);
  void add_texels(const TrianglesOfPixel& triangles, const Eigen::Vector3d& ray, const PlaceLayer& noted,
                  LightSum& sum);
  void add_noted(const TrianglesOfPixel& triangles, const Eigen::Vector3d& ray, std::uint32_t layer,
                 LightSum& sum);
  void add_depths(const TrianglesOfPixel& triangles, const Eigen::Vector3d& ray, const PlacePiece& piece,
                  double first, double last, DepthSum& by_depth) const;
  [[nodiscard]] LightSum light_at(const TrianglesOfPixel& triangles, const Eigen::Vector3d& ray,
                                  const PlacePiece& piece, double time) const;

  SurfaceModel model_;
  StillPixel still_;
  PixelSweep sweep_;
  PlaceSweep places_;
  PlaceView view_;
  PlacePeel peel_;
  TexelWay way_;
  MeshPixel meshes_;
  std::vector<Ticks> breaks_;
  std::vector<double> cuts_;
};

}  // namespace swept
