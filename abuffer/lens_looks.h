// When and through which point of a lens the sampled engine looks at a scene. For the project's own sources.
//
// Of given points each has as many instants as the next, which begin at another time for each, so that those
// of all points together fill the exposure (model section 16). Where their number is to be found, looks are
// points of one sequence over lens and time: the first N of it, N a power of two, fill both evenly, and so do
// the next N by themselves, so that the difference of the two halves of 2N tells how much is left.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "abuffer/sampled.h"
#include "abuffer/scrambled_sobol.h"
#include "splat/lens_points.h"
#include "splat/scene.h"

namespace swept {

struct LensLook {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();  ///< of the lens, as CameraTrack::lens_point
  double share = 0.5;                               ///< of the exposure's light
};

class LensLooks {
 public:
  /// None: there is no lens.
  LensLooks() = default;
  /// `samples`: as SampledOptions has them. Where neither they nor the scene say how many looks there are, a
  /// sequence.
  LensLooks(const Scene& scene, int samples) : aperture_(scene.camera.aperture) {
    if (!(aperture_.radius > 0.0)) return;
    any_ = true;
    if (samples == 0 && aperture_.samples == 0) return;
    points_ = lens_points(aperture_, lens_point_count(scene));
  }

  [[nodiscard]] bool any() const { return any_; }
  [[nodiscard]] bool given() const { return !points_.empty(); }
  [[nodiscard]] int points() const { return static_cast<int>(points_.size()); }

  /// Look `i`. Of given points, `instants` for each.
  [[nodiscard]] LensLook at(int i, int instants) const {
    return given() ? paired(i / instants, i % instants, instants)
                   : of_sequence(static_cast<std::uint32_t>(i));
  }

 private:
  [[nodiscard]] LensLook paired(int point, int k, int instants) const {
    // Van der Corput's sequence: half a point's spacing at least from the ends of its stratum.
    double start = 0.0, digit = 0.5;
    for (int rest = point; rest > 0; rest /= 2, digit *= 0.5) start += digit * (rest % 2);
    start += 0.5 / static_cast<double>(points_.size());
    return {points_[static_cast<std::size_t>(point)], std::min(1.0, (k + start) / instants)};
  }

  [[nodiscard]] LensLook of_sequence(std::uint32_t i) const {
    constexpr std::uint32_t seeds[3] = {0x9e3779b9U, 0x85ebca6bU, 0xc2b2ae35U};  // any
    std::uint32_t sobol[3];
    directions_.at(i, sobol);
    const auto share = [](std::uint32_t digits, std::uint32_t seed) {
      return double{unit_interval(scrambled(digits, seed))};
    };
    return {point_on_lens(aperture_, share(i, seeds[0]), share(reversed_digits(sobol[0]), seeds[1])),
            share(reversed_digits(sobol[1]), seeds[2])};
  }

  Aperture aperture_;
  bool any_ = false;
  std::vector<Eigen::Vector2d> points_;
  SobolDirections directions_;
};

/// What cannot be had of given points, of which each has to be looked through.
[[nodiscard]] inline Status check_lens(const LensLooks& looks, const SampledOptions& options) {
  if (!looks.given()) return Done{};
  if (options.max_seconds > 0.0)
    return Error{"", "max_seconds",
                 "cannot be given to a lens whose points are given, and all looked through",
                 ErrorKind::unsupported};
  if (options.error_channel)
    return Error{"", "error_channel", "a lens whose points are given has no estimate of its error",
                 ErrorKind::unsupported};
  return Done{};
}

/// `most`: looks of any cell.
inline void describe_lens(const LensLooks& looks, int most, Statistics& statistics) {
  const int points = looks.given() ? looks.points() : most;
  statistics.count("lens_points", points);
  statistics.effect(looks.given() ? "depth of field: instants paired with " + std::to_string(points) +
                                        " points of the lens"
                                  : "depth of field: up to " + std::to_string(points) +
                                        " points of the lens, each at an instant of its own");
}

/// The scene as a pinhole: without its objects, for what is made of film, camera and models.
[[nodiscard]] inline Scene pinhole_of(const Scene& scene) {
  Scene pinhole;
  pinhole.film = scene.film;
  pinhole.model = scene.model;
  pinhole.splats = scene.splats;
  pinhole.camera = scene.camera;
  pinhole.camera.aperture = {};
  return pinhole;
}

/// Weights of look `i` of `count` in the sums that the error is estimated from: the halves' difference.
[[nodiscard]] inline float half_of_looks(int i, int count) { return i < count / 2 ? 1.0f : -1.0f; }

/// How many looks a cell begins with, a power of two: as many as its motion takes, and enough to find a pixel
/// in what a point is spread over.
[[nodiscard]] inline int first_looks(double blur_px, int instants) {
  constexpr double px_per_look = 4.0, most = 512.0;
  const double wanted =
      std::max(std::min(most, 0.785 * blur_px * blur_px / px_per_look), double{1.0} * instants);
  int count = 16;
  while (count < wanted && count < (1 << 14)) count *= 2;
  return count;
}

}  // namespace swept
