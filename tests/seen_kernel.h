// What a ray sees of a kernel on its way: by instants, and of a fragment.
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "splat/kernel/ray_kernel.h"
#include "splat/kernel/turning_kernel.h"

namespace swept::test {

inline constexpr double kernel_delta = 3.0;

inline Eigen::Vector3d place_at(const MovingKernel& kernel, double time) {
  const double s = time - double{kernel.t_mid()}, half = kernel.half_time();
  return kernel.center + s * kernel.velocity + (s * s - half * half / 3.0) * kernel.bend;
}

struct Seen {
  double light = 0.0, depth = 0.0, time = 0.0;  ///< ∫ρ, ∫ρz and ∫ρτ
};

/// By 20,000 instants, each a disc that stands still; null: its axes and weight keep to those of the middle.
inline Seen seen_by_instants(const MovingKernel& kernel, const DiscTurn* turn, double x, double y) {
  Seen seen;
  constexpr int instants = 20'000;
  const double length = 2.0 * kernel.half_time();
  for (int k = 0; k < instants; ++k) {
    const double time = kernel.t_begin + length * (k + 0.5) / instants;
    double of_kernel = kernel.weight;
    MovingKernel still = kernel;
    still.center = place_at(kernel, time);
    still.velocity.setZero();
    still.bend.setZero();
    if (turn != nullptr) {
      const double s = time - double{turn->t_mid};
      const DiscTurn::Axes axes = turn->at(kernel, time);
      still.axis_u = axes.u.cast<float>();
      still.axis_v = axes.v.cast<float>();
      of_kernel += s * (turn->weight_rate + s * turn->weight_bend);
    }
    const RayCoordinates<double> at = KernelPlane<double>(still).along(x, y);
    const double square = at.u * at.u + at.v * at.v;
    if (square > 1.0) continue;
    const double weight = of_kernel * std::exp(-kernel_delta * square) * length / instants;
    seen.light += weight;
    seen.depth += weight * at.z;
    seen.time += weight * time;
  }
  return seen;
}

inline Seen seen_of(const RayFragment<double>& f) {
  Seen seen;
  constexpr int parts = 2000;
  const double length = f.t_end - f.t_begin;
  for (int k = 0; k < parts; ++k) {
    const double since = length * (k + 0.5) / parts, y = f.y_begin + f.rate * since;
    const double weight = f.peak * std::exp(-y * y) * length / parts;
    seen.light += weight;
    seen.depth += weight * (f.z_begin + f.z_rate * since);
    seen.time += weight * (f.t_begin + since);
  }
  return seen;
}

}  // namespace swept::test
