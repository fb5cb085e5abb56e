// One triangle of a mesh over the exposure: where and when samples may meet it, and whether one does.
// Source: Gribel et al. 2013, sections 3 and 4.
#pragma once

#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include "abuffer/stochastic/enclosure.h"
#include "abuffer/stochastic/film_reach.h"
#include "abuffer/stochastic/mesh_paths.h"
#include "abuffer/stochastic/pixel_samples.h"
#include "abuffer/stochastic/sample_hits.h"

namespace swept::stochastic {

/// The ray of a sample: o + z d, d = (x, y, 1), o in the plane of the eye.
struct SampleRay {
  double x, y, from_x, from_y;
};
/// Of entry k, which lies in pixel (x, y).
[[nodiscard]] inline SampleRay ray_of(const BlockSamples& samples, std::size_t k, double x, double y,
                                      const Projection& film, double per_focal) {
  SampleRay ray{(x + double{samples.x[k]} - film.center_x) * per_focal,
                (y + double{samples.y[k]} - film.center_y) * per_focal, 0.0, 0.0};
  if (samples.lens_x.empty()) return ray;
  ray.x -= double{samples.toward_x[k]}, ray.y -= double{samples.toward_y[k]};
  ray.from_x = double{samples.lens_x[k]}, ray.from_y = double{samples.lens_y[k]};
  return ray;
}

class MovingTriangle {
 public:
  MovingTriangle(const MeshPaths& paths, std::uint32_t triangle, const FilmView& view);

  // What traverse() asks of a primitive. Times are 0 where the shutter opens and 1 where it closes.
  [[nodiscard]] static const float* times(const BlockSamples& samples) { return samples.time.data(); }
  static constexpr bool by_share = false;  ///< times are of the shutter, not shares of the light
  [[nodiscard]] bool straight() const { return degree_ == 1; }
  [[nodiscard]] int pieces() const { return paths_.pieces(); }
  [[nodiscard]] Span piece(int p) const { return {paths_.cut(p), paths_.cut(p + 1)}; }
  [[nodiscard]] int piece_of(float time) const { return paths_.piece_of(double{time}); }
  /// Pixels of `window` in which a sample of that time may meet it.
  [[nodiscard]] PixelRange pixels(const Span& time, const PixelRange& window) const;
  /// Gets ready for tiles within a range of pixels.
  void begin_tiles(int piece, const PixelRange& range, int tile_px, CurveBounds bounds);
  /// The time within the piece in which samples of the tile at (x, y) may meet it.
  [[nodiscard]] Span tile(int x, int y) const;
  /// Puts the corners where they are at one instant.
  void place(float time);
  /// Whether sample k, of pixel (x, y), meets it where it was placed; or at its own time.
  bool test_placed(const BlockSamples& samples, std::size_t k, int x, int y, SampleHits& hits) const;
  bool test(const BlockSamples& samples, std::size_t k, int x, int y, SampleHits& hits) {
    place(samples.time[k]);
    return test_placed(samples, k, x, y, hits);
  }

 private:
  /// Its light where corners have these shares of it.
  void add_light(const Eigen::Vector3d& shares, double (&rgba)[4]) const;
  void begin_edges(int piece, int tile_px);
  [[nodiscard]] Span plane(int axis, int side, double tangent) const;
  [[nodiscard]] Span edges(double x, double y) const;

  const MeshPaths& paths_;
  const FilmView& view_;
  double per_focal_;
  std::uint32_t corner_[3];
  int degree_;
  std::uint32_t triangle_;
  bool opaque_;
  Eigen::Vector3d at_[3];  ///< where it was placed
  float placed_ = 0.0f;    ///< and when

  // Of begin_tiles().
  CurveBounds bounds_ = CurveBounds::slefes;
  Span time_;
  double half_ = 0.0;  ///< of a tile's side, as a tangent
  /// Bounds from below of how far all corners are outside of a tile's side, at both ends of a range of
  /// tangents and linear between them: values at breaks, or of control points.
  struct Side {
    double low[3], high[3];
  } side_[2][2];  ///< [axis][0: left or top, 1: right or bottom]
  double tangent_low_[2], tangent_high_[2];
  struct Edge {
    Eigen::Vector3d normal[most_degree + 1];  ///< control points of the edge function (Eq. 3)
    Eigen::Vector3d along[most_degree + 1];   ///< and of p − q
    double pad[most_degree + 1];              ///< what the tile's extent and rounding may add
  } edge_[3];
};

}  // namespace swept::stochastic
