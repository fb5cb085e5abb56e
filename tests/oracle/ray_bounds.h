// The error bounds that ray_kernel.h states, and by how much a result uses them up.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "splat/kernel/ray_kernel.h"
#include "tests/oracle/hard_kernels.h"
#include "tests/oracle/oracle.h"

namespace swept::oracle {

struct CoordinateBounds {
  double u, v, z, du, dv, dz;
};

/// Those of KernelPlane::along, at the exact coordinates, for a type of the given unit roundoff.
[[nodiscard]] CoordinateBounds coordinate_bounds(const MovingKernel& kernel, double x, double y,
                                                 const Ray& exact, double unit = 0x1p-53);

/// Whether the ray lies in the disc's plane but for rounding, 4 ε N of n·d: its coordinates then need not
/// even be finite.
[[nodiscard]] inline bool in_plane(const Ray& exact, double unit) { return !(exact.facing_ratio > 8 * unit); }

/// The largest of |error| / bound over the six coordinates; NaN in the plane, infinity for a result of NaN.
[[nodiscard]] double coordinate_error(const MovingKernel& kernel, double x, double y,
                                      const RayCoordinates<double>& computed, double unit = 0x1p-53);

/// Errors of tube results, as shares of their bounds: at most 1 where these hold.
struct TubeError {
  double interval = 0.0, missed = 0.0, y = 0.0, z = 0.0, peak = 0.0;
  int hits = 0;

  void include(const TubeError& other) {
    // A NaN stays.
    const auto larger = [](double a, double b) { return a <= b || std::isnan(b) ? b : a; };
    interval = larger(interval, other.interval);
    missed = larger(missed, other.missed);
    y = larger(y, other.y);
    z = larger(z, other.z);
    peak = larger(peak, other.peak);
    hits += other.hits;
  }
};

/// `intersect` is called like swept::intersect_tube, with weight 1.
template <class T, class Intersect>
[[nodiscard]] TubeError tube_error(const RayCoordinates<T>& ray, T begin, T end, T near, T delta,
                                   Intersect intersect, Digits digits = Digits::fifty) {
  constexpr double unit = std::numeric_limits<T>::epsilon() / 2;
  const RayCoordinates<double> exact_ray{ray.u, ray.v, ray.z, ray.du, ray.dv, ray.dz};
  const double t_mid = 0.5 * (double{begin} + double{end});
  const double w = std::hypot(exact_ray.u, exact_ray.v), s = std::hypot(exact_ray.du, exact_ray.dv);
  const double radius_bound = 16 * unit * (1 + w + s);
  const double depth_bound = 4 * unit * (std::abs(exact_ray.z) + double{near} + std::abs(exact_ray.dz));
  TubeError result;
  RayFragment<T> f;
  if (!intersect(ray, begin, end, near, delta, T(1), f)) {
    const Fragment exact = intersect_tube(exact_ray, begin, end, near, delta, 1.0, digits);
    if (!exact.hit) return result;
    // It must have been missed by a bound's breadth: half way through it is still at an edge.
    const double middle = 0.5 * (exact.t_begin.high + exact.t_end.high);
    const State state = state_at(exact_ray, t_mid, middle, digits);
    result.missed = std::min(-state.radius_minus_one / radius_bound, (state.z - double{near}) / depth_bound);
    return result;
  }
  result.hits = 1;
  for (const T t : {f.t_begin, f.t_end}) {
    const State state = state_at(exact_ray, t_mid, t, digits);
    const double beyond_tube = state.radius_minus_one / radius_bound,
                 before_near = (double{near} - state.z) / depth_bound;
    // Inside both, and at the edge of one unless it is the segment's.
    double at_edge = std::min(std::abs(beyond_tube), std::abs(before_near));
    if (t == begin || t == end) at_edge = 0.0;
    const double error = std::max({beyond_tube, before_near, at_edge});
    result.interval = error <= result.interval ? result.interval : error;
  }
  const State state = state_at(exact_ray, t_mid, f.t_begin, digits);
  const double root_delta = std::sqrt(double{delta});
  const bool moves = s >= double{std::numeric_limits<T>::min()};
  if (moves)
    result.y = std::abs(double{f.y_begin} - root_delta * state.along) /
               (24 * unit * root_delta * (1 + w + s) + 2 * 0x1p-53 * std::abs(f.y_begin));
  result.z =
      std::abs(double{f.z_begin} - state.z) / (4 * unit * (std::abs(exact_ray.z) + std::abs(exact_ray.dz)));
  const double across = moves ? state.across : w;
  // As an exponent, for peak has no digits left where `across` has none. The second part is the error of the
  // logarithm and of the product with `across` rounded.
  const double moved = 5 * unit * w;
  const double peak_bound = double{delta} * moved * (2 + moved) + unit * (2 * double{delta} + 3) +
                            0x1p-53 * (4 * double{delta} + 3);
  result.peak = std::abs(std::log(double{f.peak}) + double{delta} * across * across) / peak_bound;
  return result;
}

/// Lines that meet the unit disc or touch it, at speeds from 10⁻³⁰⁰ to 10⁷, at depths about the near plane.
template <class T>
[[nodiscard]] RayCoordinates<T> planted_coordinates(Random& random) {
  const double slowest = sizeof(T) == 4 ? -36.0 : -300.0;
  const double speed = random() % 4 ? std::pow(10.0, uniform(random, -6.0, 6.0))
                                    : std::pow(10.0, uniform(random, slowest, 7.0));
  const double heading = uniform(random, 0.0, 6.283185307179586);
  const double c = std::cos(heading), n = std::sin(heading);
  double across = uniform(random, -1.2, 1.2);
  if (random() % 3 == 0)  // tangent
    across = std::copysign(1.0, across) + magnitude(random, sizeof(T) == 4 ? -8.0 : -16.0, -1.0);
  const double along = uniform(random, -1.5, 1.5) + uniform(random, -0.5, 0.5) * speed;
  const double z = random() % 2 ? uniform(random, 0.05, 0.2) : std::pow(10.0, uniform(random, 0.0, 4.0));
  const double dz = random() % 3 ? z * magnitude(random, -8.0, 1.0) : 0.0;
  return {static_cast<T>(along * c - across * n),
          static_cast<T>(along * n + across * c),
          static_cast<T>(z),
          static_cast<T>(speed * c),
          static_cast<T>(speed * n),
          static_cast<T>(dz)};
}

/// Of a kernel of a hard case, as KernelPlane gives them; `hard` null: planted ones.
template <class T>
[[nodiscard]] RayCoordinates<T> coordinates_of(const HardCase* hard, Random& random) {
  if (!hard) return planted_coordinates<T>(random);
  const auto [kernel, x, y] = hard->make(random);
  return KernelPlane<T>(kernel).along(static_cast<T>(x), static_cast<T>(y));
}

}  // namespace swept::oracle
