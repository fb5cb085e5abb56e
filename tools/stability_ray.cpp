#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/core.h>

#include "splat/kernel/kernel_integral.h"
#include "splat/kernel/ray_kernel.h"
#include "tests/oracle/hard_kernels.h"
#include "tests/oracle/naive.h"
#include "tests/oracle/ray_bounds.h"
#include "tools/stability_rows.h"

namespace swept::stability {
namespace {

using oracle::Digits;
using oracle::Exact;
using oracle::Random;
using oracle::uniform;

template <class T>
std::vector<Row> coordinate_rows(const oracle::HardCase& hard, std::size_t points, std::uint64_t seed) {
  Random random(seed);
  OracleCheck check;
  Collector uv, naive_uv, z, naive_z;
  std::map<std::string, std::size_t> branches;
  for (std::size_t i = 0; i < points; ++i) {
    const oracle::KernelAndRay input = hard.make(random);
    const MovingKernel& kernel = input.kernel;
    const T x = static_cast<T>(input.x), y = static_cast<T>(input.y);
    const oracle::Ray exact = oracle::along(kernel, x, y, Digits::quad);
    if (oracle::in_plane(exact, unit_roundoff<T>)) {
      ++branches["in the plane, left out"];
      continue;
    }
    const oracle::CoordinateBounds bounds = oracle::coordinate_bounds(kernel, x, y, exact, unit_roundoff<T>);
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
      return to.add(value, of, ulp, oracle::error(value, of) / bound, where);
    };
    bool worst = add(uv, ours.u, exact.u, 1.0, bounds.u);
    worst |= add(uv, ours.v, exact.v, 1.0, bounds.v);
    add(naive_uv, theirs.u, exact.u, 1.0, 1.0);
    add(naive_uv, theirs.v, exact.v, 1.0, 1.0);
    worst |= add(z, ours.z, exact.z, 0.0, bounds.z);
    add(naive_z, theirs.z, exact.z, 0.0, 1.0);
    if (!check.wants(i, worst)) continue;
    const oracle::Ray fifty = oracle::along(kernel, x, y, Digits::fifty);
    check.include(exact.u, fifty.u, oracle::ulp<T>(std::max(std::abs(exact.u.high), 1.0)));
    check.include(exact.v, fifty.v, oracle::ulp<T>(std::max(std::abs(exact.v.high), 1.0)));
    check.include(exact.z, fifty.z, oracle::ulp<T>(exact.z.high));
  }
  const std::size_t uv_points = uv.points(), z_points = z.points();
  return {{"coordinates (u, v)", hard.name, type_name<T>, case_range, check.text(),
           describe_branches(branches), uv_points, true, uv.finish(), naive_uv.finish()},
          {"depth along the ray", hard.name, type_name<T>, case_range, check.text(), "", z_points, true,
           z.finish(), naive_z.finish()}};
}

constexpr auto stable = []<class T>(const RayCoordinates<T>& ray, T begin, T end, T near, T delta, T weight,
                                    RayFragment<T>& f) {
  return intersect_tube(ray, begin, end, near, delta, weight, f);
};

/// Fragments of exact coordinates. `hard` null: planted ones, tangent and at every speed.
template <class T>
std::vector<Row> tube_rows(const oracle::HardCase* hard, std::size_t points, std::uint64_t seed) {
  Random random(seed);
  OracleCheck check;
  Collector time, naive_time, peak, naive_peak, depth, naive_depth;
  std::map<std::string, std::size_t> branches;
  const T near = static_cast<T>(oracle::near_depth), delta = T(3);
  for (std::size_t i = 0; i < points; ++i) {
    const RayCoordinates<T> ray = oracle::coordinates_of<T>(hard, random);
    if (!std::isfinite(double{ray.u} + ray.v + ray.z + ray.du + ray.dv + ray.dz)) continue;
    const RayCoordinates<double> inputs{ray.u, ray.v, ray.z, ray.du, ray.dv, ray.dz};
    const oracle::Fragment exact = oracle::intersect_tube(inputs, 0.0, 1.0, near, delta, 1.0, Digits::quad);
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
        return times.add(exact.t_begin.high, exact.t_end, ulp, share.missed, where);
      }
      bool worst = times.add(g.t_begin, exact.t_begin, ulp, share.interval, where);
      worst |= times.add(g.t_end, exact.t_end, ulp, share.interval, where);
      if (oracle::normal<T>(exact.peak))
        worst |= peaks.add(g.peak, exact.peak, oracle::ulp<T>(exact.peak.high), share.peak, where);
      worst |= depths.add(g.z_begin, exact.z_begin, oracle::ulp<T>(exact.z_begin.high), share.z, where);
      return worst;
    };
    const bool worst = add(hit, f, time, peak, depth,
                           oracle::tube_error(ray, T(0), T(1), near, delta, stable, Digits::quad));
    if (check.wants(i, worst)) {
      const oracle::Fragment fifty =
          oracle::intersect_tube(inputs, 0.0, 1.0, near, delta, 1.0, Digits::fifty);
      check.include(exact.t_begin, fifty.t_begin, oracle::ulp<T>(0.75));
      check.include(exact.t_end, fifty.t_end, oracle::ulp<T>(0.75));
      if (oracle::normal<T>(exact.peak))
        check.include(exact.peak, fifty.peak, oracle::ulp<T>(exact.peak.high));
      check.include(exact.z_begin, fifty.z_begin, oracle::ulp<T>(exact.z_begin.high));
    }
    RayFragment<T> g;
    const bool naive_hit = naive::intersect_tube(ray, T(0), T(1), near, delta, T(1), g);
    add(naive_hit, g, naive_time, naive_peak, naive_depth, {});
  }
  const std::string name = hard ? hard->name : "tangent, and at every speed";
  const char* range = hard ? case_range : "distances 1 ± 10⁻¹⁶, speeds 10⁻³⁰⁰ to 10⁷ (float: ± 10⁻⁸, 10⁻³⁶)";
  const std::size_t times = time.points(), peaks = peak.points(), depths = depth.points();
  if (times == 0) return {};
  return {{"tube: entry and exit time", name, type_name<T>, range, check.text(), describe_branches(branches),
           times, true, time.finish(), naive_time.finish()},
          {"tube: peak", name, type_name<T>, range, check.text(), "", peaks, true, peak.finish(),
           naive_peak.finish()},
          {"tube: depth at entry", name, type_name<T>, range, check.text(), "", depths, true, depth.finish(),
           naive_depth.finish()}};
}

}  // namespace

void add_coordinate_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs) {
  for (const oracle::HardCase& hard : oracle::hard_cases()) {
    jobs.push_back([&hard, points, seed] { return coordinate_rows<double>(hard, points, seed); });
    jobs.push_back([&hard, points, seed] { return coordinate_rows<float>(hard, points, seed); });
  }
}

void add_tube_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs) {
  std::vector<const oracle::HardCase*> cases = {nullptr};
  for (const oracle::HardCase& hard : oracle::hard_cases()) cases.push_back(&hard);
  for (const oracle::HardCase* hard : cases) {
    jobs.push_back([hard, points, seed] { return tube_rows<double>(hard, points, seed); });
    jobs.push_back([hard, points, seed] { return tube_rows<float>(hard, points, seed); });
  }
}

}  // namespace swept::stability
