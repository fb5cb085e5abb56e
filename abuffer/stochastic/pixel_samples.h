// Where and when each pixel's samples look at the scene: places in the pixel and on the lens, and instants.
//
// A pixel's samples are Hammersley's in five dimensions: strata of the time, and the first four dimensions of
// Sobol's sequence, scrambled as Owen 1995 does by the hash of Laine and Karras 2011, each pixel by a seed of
// its own. So any number of samples is well spread in each dimension and jointly, and neighbours are
// independent.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "abuffer/scrambled_sobol.h"
#include "abuffer/sources/rasterize.h"
#include "splat/camera.h"
#include "splat/exposure.h"
#include "splat/scene.h"

namespace swept::stochastic {

/// How far rays may begin from the eye and how they run together, in the space of the projection, over the
/// whole exposure: what bounds have to allow for.
struct LensReach {
  double x = 0.0, y = 0.0;  ///< of the lens's points along the axes, at most
  double least_inverse_focus = 0.0, most_inverse_focus = 0.0;

  [[nodiscard]] bool any() const { return x > 0.0 || y > 0.0; }
  /// How far a ray through a place of the film may be from the one through the middle of the lens, at depth
  /// z, as a tangent: `reach` |1/z − 1/focus|.
  [[nodiscard]] double tangent(double reach, double z) const;
};

/// The samples of a rectangle of pixels: entry (pixel · per_pixel + i), each pixel's in the order of their
/// times.
struct BlockSamples {
  Window window;
  int per_pixel = 0;
  std::vector<float> x, y;            ///< in the pixel, [0, 1)
  std::vector<float> lens_x, lens_y;  ///< where the ray begins; empty without a lens, and so are the next two
  std::vector<float> toward_x, toward_y;  ///< lens_x/focus, lens_y/focus
  std::vector<float> share;               ///< shutter time: the share of the light, [0, 1)
  std::vector<float> time;             ///< the time itself, 0 where the shutter opens and 1 where it closes
  std::vector<std::uint16_t> instant;  ///< which of the shared instants; empty where there are none
};

class SampleSource {
 public:
  /// `times` as in StochasticOptions.
  SampleSource(const Scene& scene, const Exposure& exposure, int samples, int times);

  void fill(const Window& window, BlockSamples& samples) const;

  [[nodiscard]] int samples() const { return samples_; }
  [[nodiscard]] int times() const { return times_; }
  [[nodiscard]] const LensReach& reach() const { return reach_; }
  /// The time at a share of the light, [0, 1].
  [[nodiscard]] float time_of(double share) const;
  /// The share of a shared instant, as the samples have it.
  [[nodiscard]] float instant_share(int instant) const {
    return static_cast<float>((instant + 0.5) / times_);
  }

 private:
  struct LensAt {
    double inverse_focus, x, y;  ///< x and y: from the lens's own axes to the projection's
  };
  [[nodiscard]] LensAt lens_at(double time) const;

  Exposure exposure_;
  int samples_, times_;
  Aperture aperture_;
  std::vector<LensAt> lens_;  ///< at evenly spaced times; one: it does not change; empty: a pinhole
  LensReach reach_;
  SobolDirections directions_;
};

}  // namespace swept::stochastic
