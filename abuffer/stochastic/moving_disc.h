// One segment of a disc over the exposure: where and when samples may meet it, and whether one does. Source:
// model sections 2 and 16. Rays go through the pixels' centres.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "abuffer/stochastic/enclosure.h"
#include "abuffer/stochastic/film_reach.h"
#include "abuffer/stochastic/pixel_samples.h"
#include "abuffer/stochastic/sample_hits.h"
#include "splat/kernel/moving_kernel.h"

namespace swept::stochastic {

class MovingDisc {
 public:
  MovingDisc(const MovingKernel& kernel, double delta, const FilmView& view);

  /// False of one that nothing can meet.
  [[nodiscard]] bool exists() const { return exists_; }

  // What traverse() asks of a primitive; times are shares of the light, as a segment's.
  [[nodiscard]] static const float* times(const BlockSamples& samples) { return samples.share.data(); }
  static constexpr bool by_share = true;
  [[nodiscard]] static constexpr bool straight() { return true; }
  [[nodiscard]] int pieces() const { return 1; }
  [[nodiscard]] Span piece(int) const { return {0.0, 1.0}; }
  [[nodiscard]] int piece_of(float) const { return 0; }
  [[nodiscard]] PixelRange pixels(const Span& time, const PixelRange& window) const;
  void begin_tiles(int, const PixelRange&, int tile_px, CurveBounds) { tile_px_ = tile_px; }
  [[nodiscard]] Span tile(int x, int y) const;
  void place(float time) { center_ = center_at(double{time}), placed_ = time; }
  bool test_placed(const BlockSamples& samples, std::size_t k, int x, int y, SampleHits& hits) const;
  bool test(const BlockSamples& samples, std::size_t k, int x, int y, SampleHits& hits) {
    place(samples.share[k]);
    return test_placed(samples, k, x, y, hits);
  }

 private:
  [[nodiscard]] Eigen::Vector3d center_at(double time) const {
    return kernel_.center + (time - double{kernel_.t_mid()}) * kernel_.velocity;
  }
  [[nodiscard]] std::array<float, 4> light() const;  ///< at the instant it was placed at
  [[nodiscard]] float tolerance() const;             ///< the same
  [[nodiscard]] Span plane(int axis, int side, double tangent) const;

  const MovingKernel& kernel_;
  const FilmView& view_;
  double delta_, per_focal_;
  bool exists_;
  Eigen::Vector3d axis_u_, axis_v_, normal_, dual_u_, dual_v_, half_;  ///< half_: of the box about the disc
  Eigen::Vector3d center_;                                             ///< where it was placed
  float placed_ = 0.0f;
  int tile_px_ = 1;
};

}  // namespace swept::stochastic
