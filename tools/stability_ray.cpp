#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/core.h>

#include "splat/kernel_integral.h"
#include "splat/ray_kernel.h"
#include "tests/oracle/hard_kernels.h"
#include "tests/oracle/naive.h"
#include "tests/oracle/ray_bounds.h"
#include "tools/stability_rows.h"

namespace swept::stability {
namespace {

using oracle::Exact;
using oracle::Random;
using oracle::uniform;

template <class T>
constexpr const char* type_name = sizeof(T) == 4 ? "float" : "double";
template <class T>
constexpr double unit_roundoff = std::numeric_limits<T>::epsilon() / 2;

constexpr const char* case_range = "model section 10, 1000 px of focal length";
constexpr const char* fifty = "50 digits";

template <class T>
void add_coordinate_rows_of(const oracle::HardCase& hard, std::size_t points, std::uint64_t seed,
                            std::vector<Row>& rows) {
  Random random(seed);
  Collector uv, naive_uv, z, naive_z;
  std::map<std::string, std::size_t> branches;
  for (std::size_t i = 0; i < points; ++i) {
    const oracle::KernelAndRay input = hard.make(random);
    const MovingKernel& kernel = input.kernel;
    const T x = static_cast<T>(input.x), y = static_cast<T>(input.y);
    const oracle::Ray exact = oracle::along(kernel, x, y);
    if (oracle::in_plane(exact, unit_roundoff<T>)) {
      ++branches["in the plane, left out"];
      continue;
    }
    const oracle::CoordinateBounds bounds = oracle::coordinate_bounds(kernel, x, y, unit_roundoff<T>);
    const RayCoordinates<T> ours = KernelPlane<T>(kernel).along(x, y);
    const RayCoordinates<T> theirs = naive::along<T>(kernel, x, y);
    const auto where = [&] {
      return fmt::format("n·d {:.1e}, |c|/|a| {:.1e}, |m|/|a| {:.1e}", exact.facing_ratio,
                         kernel.center.norm() / double{kernel.axis_u.norm()},
                         kernel.velocity.norm() / double{kernel.axis_u.norm()});
    };
    ++branches[kernel.center.z() > 0.0 ? "from the centre" : "from the axis"];
    // A disc's coordinates are about 1 where it is seen; nearer its centre they need no more digits.
    const auto add = [&](Collector& to, T value, Exact of, double least, double bound) {
      const double ulp = oracle::ulp<T>(std::max(std::abs(of.high), least));
      to.add(value, of, ulp, oracle::error(value, of) / bound, where);
    };
    add(uv, ours.u, exact.u, 1.0, bounds.u);
    add(uv, ours.v, exact.v, 1.0, bounds.v);
    add(naive_uv, theirs.u, exact.u, 1.0, 1.0);
    add(naive_uv, theirs.v, exact.v, 1.0, 1.0);
    add(z, ours.z, exact.z, 0.0, bounds.z);
    add(naive_z, theirs.z, exact.z, 0.0, 1.0);
  }
  const std::size_t uv_points = uv.points(), z_points = z.points();
  rows.push_back({"coordinates (u, v)", hard.name, type_name<T>, case_range, fifty,
                  describe_branches(branches), uv_points, true, uv.finish(), naive_uv.finish()});
  rows.push_back({"depth along the ray", hard.name, type_name<T>, case_range, fifty, "", z_points, true,
                  z.finish(), naive_z.finish()});
}

template <class T>
RayCoordinates<T> coordinates_of(const oracle::HardCase* hard, Random& random) {
  if (!hard) return oracle::planted_coordinates<T>(random);
  const auto [kernel, x, y] = hard->make(random);
  return KernelPlane<T>(kernel).along(static_cast<T>(x), static_cast<T>(y));
}

constexpr auto stable = []<class T>(const RayCoordinates<T>& ray, T begin, T end, T near, T delta, T weight,
                                    RayFragment<T>& f) {
  return intersect_tube(ray, begin, end, near, delta, weight, f);
};

/// Fragments of exact coordinates. `hard` null: planted ones, tangent and at every speed.
template <class T>
void add_tube_rows_of(const oracle::HardCase* hard, std::size_t points, std::uint64_t seed,
                      std::vector<Row>& rows) {
  Random random(seed);
  Collector time, naive_time, peak, naive_peak, depth, naive_depth;
  std::map<std::string, std::size_t> branches;
  const T near = static_cast<T>(oracle::near_depth), delta = T(3);
  for (std::size_t i = 0; i < points; ++i) {
    const RayCoordinates<T> ray = coordinates_of<T>(hard, random);
    if (!std::isfinite(double{ray.u} + ray.v + ray.z + ray.du + ray.dv + ray.dz)) continue;
    const RayCoordinates<double> inputs{ray.u, ray.v, ray.z, ray.du, ray.dv, ray.dz};
    const oracle::Fragment exact = oracle::intersect_tube(inputs, 0.0, 1.0, near, delta, 1.0);
    RayFragment<T> f;
    const bool hit = intersect_tube(ray, T(0), T(1), near, delta, T(1), f);
    ++branches[!hit                                   ? "miss"
               : f.rate == T(0)                       ? "still"
               : f.t_begin == T(0) && f.t_end == T(1) ? "whole shutter"
                                                      : "cut"];
    if (!exact.hit) continue;
    const auto where = [&] {
      return fmt::format("distance {:.17g}, speed {:.1e}, w {:.1e}", exact.across,
                         std::hypot(inputs.du, inputs.dv), std::hypot(inputs.u, inputs.v));
    };
    // Times in ulp of 1: they are shutter times. A miss of what is seen counts as the whole of it.
    const auto add = [&](bool found, const RayFragment<T>& g, Collector& times, Collector& peaks,
                         Collector& depths, const oracle::TubeError& share) {
      const double ulp = oracle::ulp<T>(0.75);
      if (!found) {
        times.add(exact.t_begin.high, exact.t_end, ulp, share.missed, where);
        return;
      }
      times.add(g.t_begin, exact.t_begin, ulp, share.interval, where);
      times.add(g.t_end, exact.t_end, ulp, share.interval, where);
      if (oracle::normal<T>(exact.peak))
        peaks.add(g.peak, exact.peak, oracle::ulp<T>(exact.peak.high), share.peak, where);
      depths.add(g.z_begin, exact.z_begin, oracle::ulp<T>(exact.z_begin.high), share.z, where);
    };
    add(hit, f, time, peak, depth, oracle::tube_error(ray, T(0), T(1), near, delta, stable));
    RayFragment<T> g;
    const bool naive_hit = naive::intersect_tube(ray, T(0), T(1), near, delta, T(1), g);
    add(naive_hit, g, naive_time, naive_peak, naive_depth, {});
  }
  const std::string name = hard ? hard->name : "tangent, and at every speed";
  const char* range = hard ? case_range : "distances 1 ± 10⁻¹⁶, speeds 10⁻³⁰⁰ to 10⁷ (float: ± 10⁻⁸, 10⁻³⁶)";
  const std::size_t times = time.points(), peaks = peak.points(), depths = depth.points();
  if (times == 0) return;
  rows.push_back({"tube: entry and exit time", name, type_name<T>, range, fifty, describe_branches(branches),
                  times, true, time.finish(), naive_time.finish()});
  rows.push_back(
      {"tube: peak", name, type_name<T>, range, fifty, "", peaks, true, peak.finish(), naive_peak.finish()});
  rows.push_back({"tube: depth at entry", name, type_name<T>, range, fifty, "", depths, true, depth.finish(),
                  naive_depth.finish()});
}

template <class T>
double integral_of(const RayFragment<T>& f) {
  const T duration = f.t_end - f.t_begin;
  return interval_integral(f.peak, duration, f.y_begin, f.y_begin + f.rate * duration);
}

RayFragment<float> stored(const RayFragment<double>& f) {
  return {static_cast<float>(f.t_begin), static_cast<float>(f.t_end), static_cast<float>(f.peak),
          static_cast<float>(f.y_begin), static_cast<float>(f.rate),  static_cast<float>(f.z_begin),
          static_cast<float>(f.z_rate)};
}

/// ∫ρ over a fragment, of exact coordinates: in double, and in float after rounding the fragment, as the
/// A-buffer keeps it.
void add_fragment_rows_of(const oracle::HardCase* hard, std::size_t points, std::uint64_t seed,
                          std::vector<Row>& rows) {
  Random random(seed);
  Collector in_double, in_float, naive;
  constexpr double delta = 3.0;
  for (std::size_t i = 0; i < points; ++i) {
    const RayCoordinates<double> ray = coordinates_of<double>(hard, random);
    if (!std::isfinite(ray.u + ray.v + ray.z + ray.du + ray.dv + ray.dz)) continue;
    const Exact exact = oracle::fragment_integral(ray, 0.0, 1.0, oracle::near_depth, delta, 1.0);
    if (!oracle::normal<float>(exact)) continue;
    const auto where = [&] {
      return fmt::format("speed {:.1e}, w {:.1e}, ∫ρ {:.1e}", std::hypot(ray.du, ray.dv),
                         std::hypot(ray.u, ray.v), exact.high);
    };
    RayFragment<double> f{};
    const bool hit = intersect_tube<double>(ray, 0.0, 1.0, oracle::near_depth, delta, 1.0, f);
    in_double.add(hit ? integral_of(f) : 0.0, exact, oracle::ulp<double>(exact.high), 0.0, where);
    const RayFragment<float> g = stored(f);
    in_float.add(hit && g.t_begin < g.t_end ? integral_of(g) : 0.0, exact, oracle::ulp<float>(exact.high),
                 0.0, where);
    RayFragment<double> n{};
    double naive_integral = 0.0;
    if (naive::intersect_tube<double>(ray, 0.0, 1.0, oracle::near_depth, delta, 1.0, n)) {
      const double duration = n.t_end - n.t_begin;
      naive_integral = n.peak * duration * naive::mean_gaussian(n.y_begin, n.y_begin + n.rate * duration);
    }
    naive.add(naive_integral, exact, oracle::ulp<double>(exact.high), 0.0, where);
  }
  const std::size_t taken = in_double.points();
  if (taken == 0) return;
  const std::string name = hard ? hard->name : "tangent, and at every speed";
  rows.push_back({"∫ρ of a fragment", name, "double", case_range, "113 bits", "", taken, false,
                  in_double.finish(), naive.finish()});
  rows.push_back({"∫ρ of a fragment stored as float", name, "float", case_range, "113 bits", "", taken, false,
                  in_float.finish(), std::nullopt});
}

template <class T>
void add_crossing_rows_of(std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  constexpr double unit = unit_roundoff<T>;
  for (const double slope : {0.0, -4.0, -8.0}) {
    Random random(seed);
    Collector ours, naive;
    for (std::size_t i = 0; i < points; ++i) {
      // Two surfaces at about z that cross at about `when`; the second nearly as fast as the first.
      const double z = std::exp2(uniform(random, -2.0, 12.0)), when = uniform(random, 0.2, 0.9);
      const T rate0 = static_cast<T>(z * uniform(random, -0.5, 0.5));
      const T rate1 = static_cast<T>(rate0 + z * oracle::magnitude(random, slope - 1.0, slope));
      const T t0 = static_cast<T>(uniform(random, 0.0, 0.2)), t1 = static_cast<T>(uniform(random, 0.0, 0.2));
      const T z0 = static_cast<T>(z + rate0 * (double{t0} - when)),
              z1 = static_cast<T>(z + rate1 * (double{t1} - when));
      if (rate0 == rate1) continue;
      const Exact exact = oracle::crossing(z0, rate0, t0, z1, rate1, t1);
      if (!(exact.high > 0.2 && exact.high < 1.0)) continue;
      const double ulp = oracle::ulp<T>(0.75);
      const auto where = [&] {
        return fmt::format("z {:.3g}, rates {:.3g} and {:.3g}", z, double{rate0}, double{rate1});
      };
      // As the sweep does: depths where the piece begins, their gap over the closing speed.
      const T begin = T(0.2);
      const T gap = (z0 + rate0 * (begin - t0)) - (z1 + rate1 * (begin - t1));
      const T time = begin + gap / (rate1 - rate0);
      // Two roundings of each depth and three of its motion, over the closing speed; and of the time.
      const double bound = unit *
                               (2 * (std::abs(double{z0}) + std::abs(double{z1})) +
                                3 * (std::abs(double{rate0}) + std::abs(double{rate1}))) /
                               std::abs(double{rate1} - double{rate0}) +
                           4 * unit;
      ours.add(time, exact, ulp, oracle::error(time, exact) / bound, where);
      // Intercepts at the shutter's opening.
      const T intercept0 = z0 - rate0 * t0, intercept1 = z1 - rate1 * t1;
      naive.add((intercept0 - intercept1) / (rate1 - rate0), exact, ulp, 0.0, where);
    }
    const std::size_t taken = ours.points();
    rows.push_back({"crossing of two depths", fmt::format("closing at 10^{:g} of the depth", slope),
                    type_name<T>, "depths 0.25 to 4096, in the sweep's form", fifty, "", taken, true,
                    ours.finish(), naive.finish()});
  }
}

}  // namespace

void add_coordinate_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    add_coordinate_rows_of<double>(hard, points, seed, rows);
    add_coordinate_rows_of<float>(hard, points, seed, rows);
  }
}

void add_tube_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  add_tube_rows_of<double>(nullptr, points, seed, rows);
  add_tube_rows_of<float>(nullptr, points, seed, rows);
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    add_tube_rows_of<double>(&hard, points, seed, rows);
    add_tube_rows_of<float>(&hard, points, seed, rows);
  }
}

void add_fragment_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  add_fragment_rows_of(nullptr, points, seed, rows);
  for (const oracle::HardCase& hard : oracle::hard_cases()) add_fragment_rows_of(&hard, points, seed, rows);
}

void add_crossing_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  add_crossing_rows_of<double>(points, seed, rows);
  add_crossing_rows_of<float>(points, seed, rows);
}

void add_filter_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    Random random(seed);
    Collector weight, size;
    for (std::size_t i = 0; i < points; ++i) {
      MovingKernel kernel = hard.make(random).kernel;
      if (!(kernel.center.z() > 0.0)) continue;
      // A depth that is a power of two: tangent and radius are then exact inputs.
      kernel.center.z() = std::exp2(std::round(std::log2(kernel.center.z())));
      PixelFilter filter;
      filter.radius = 0x1p-10;
      filter.near = kernel.center.z();
      filter.max_tangent_x = filter.max_tangent_y = 0.75;
      const Eigen::Vector3d u = kernel.axis_u.cast<double>(), v = kernel.axis_v.cast<double>();
      const FilteredDisc disc = filter_disc(kernel.center, u, v, filter);
      const Eigen::Vector2d tangent =
          (kernel.center.head<2>() / kernel.center.z()).cwiseMax(-0.75).cwiseMin(0.75);
      const oracle::Filtered exact = oracle::filter(u, v, tangent, filter.radius * kernel.center.z());
      const auto where = [&] {
        return fmt::format("|a|/r {:.1e}, weight {:.3g}", u.norm() / (filter.radius * kernel.center.z()),
                           exact.weight.high);
      };
      if (exact.weight.high > 1e-300)
        weight.add(disc.weight, exact.weight, oracle::ulp<double>(exact.weight.high), 0.0, where);
      size.add(disc.size, exact.size, oracle::ulp<double>(exact.size.high), 0.0, where);
    }
    const std::size_t weights = weight.points(), sizes = size.points();
    if (weights > 0)
      rows.push_back({"filter: weight", hard.name, "double", case_range, fifty, "", weights, false,
                      weight.finish(), std::nullopt});
    if (sizes > 0)
      rows.push_back({"filter: size", hard.name, "double", case_range, fifty, "", sizes, false, size.finish(),
                      std::nullopt});
  }
}

}  // namespace swept::stability
