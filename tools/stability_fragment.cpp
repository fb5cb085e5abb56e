#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/core.h>

#include "abuffer/sources/rasterize.h"
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

double integral_of(const RayFragment<double>& f) {
  const double duration = f.t_end - f.t_begin;
  return interval_integral(f.peak, duration, f.y_begin, f.y_begin + f.rate * duration);
}

/// As the A-buffer keeps it, in float; 0 if it does not.
double kept_integral_of(const RayFragment<double>& f) {
  FragmentArrays kept;
  kept.ensure(1);
  append(f, 0, 0, kept);
  if (kept.count == 0) return 0.0;
  const auto duration = static_cast<float>(share_of(kept.t_end[0] - kept.t_begin[0]));
  return interval_integral(kept.peak[0], duration, kept.y[0], kept.y[0] + kept.rate[0] * duration);
}

/// ∫ρ over a fragment, of exact coordinates: in double, and in float after rounding the fragment, as the
/// A-buffer keeps it.
std::vector<Row> fragment_rows(const oracle::HardCase* hard, std::size_t points, std::uint64_t seed) {
  Random random(seed);
  OracleCheck check;
  Collector in_double, in_float, naive;
  constexpr double delta = 3.0;
  for (std::size_t i = 0; i < points; ++i) {
    const RayCoordinates<double> ray = oracle::coordinates_of<double>(hard, random);
    if (!std::isfinite(ray.u + ray.v + ray.z + ray.du + ray.dv + ray.dz)) continue;
    const auto integral = [&](Digits digits) {
      return oracle::fragment_integral(ray, 0.0, 1.0, oracle::near_depth, delta, 1.0, digits);
    };
    const Exact exact = integral(Digits::quad);
    if (!oracle::normal<float>(exact)) continue;
    const auto where = [&] {
      return fmt::format("speed {:.1e}, w {:.1e}, ∫ρ {:.1e}", std::hypot(ray.du, ray.dv),
                         std::hypot(ray.u, ray.v), exact.high);
    };
    RayFragment<double> f{};
    const bool hit = intersect_tube<double>(ray, 0.0, 1.0, oracle::near_depth, delta, 1.0, f);
    bool worst =
        in_double.add(hit ? integral_of(f) : 0.0, exact, oracle::ulp<double>(exact.high), 0.0, where);
    worst |= in_float.add(hit ? kept_integral_of(f) : 0.0, exact, oracle::ulp<float>(exact.high), 0.0, where);
    if (check.wants(i, worst)) check.include(exact, integral(Digits::fifty), oracle::ulp<double>(exact.high));
    RayFragment<double> n{};
    double naive_integral = 0.0;
    if (naive::intersect_tube<double>(ray, 0.0, 1.0, oracle::near_depth, delta, 1.0, n)) {
      const double duration = n.t_end - n.t_begin;
      naive_integral = n.peak * duration * naive::mean_gaussian(n.y_begin, n.y_begin + n.rate * duration);
    }
    naive.add(naive_integral, exact, oracle::ulp<double>(exact.high), 0.0, where);
  }
  const std::size_t taken = in_double.points();
  if (taken == 0) return {};
  const std::string name = hard ? hard->name : "tangent, and at every speed";
  return {{"∫ρ of a fragment", name, "double", case_range, check.text(), "", taken, false, in_double.finish(),
           naive.finish()},
          {"∫ρ of a fragment stored as float", name, "float", case_range, check.text(), "", taken, false,
           in_float.finish(), std::nullopt}};
}

template <class T>
std::vector<Row> crossing_rows(double slope, std::size_t points, std::uint64_t seed) {
  constexpr double unit = unit_roundoff<T>;
  Random random(seed);
  OracleCheck check;
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
    const Exact exact = oracle::crossing(z0, rate0, t0, z1, rate1, t1, Digits::quad);
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
    const bool worst = ours.add(time, exact, ulp, oracle::error(time, exact) / bound, where);
    if (check.wants(i, worst))
      check.include(exact, oracle::crossing(z0, rate0, t0, z1, rate1, t1, Digits::fifty), ulp);
    // Intercepts at the shutter's opening.
    const T intercept0 = z0 - rate0 * t0, intercept1 = z1 - rate1 * t1;
    naive.add((intercept0 - intercept1) / (rate1 - rate0), exact, ulp, 0.0, where);
  }
  const std::size_t taken = ours.points();
  return {{"crossing of two depths", fmt::format("closing at 10^{:g} of the depth", slope), type_name<T>,
           "depths 0.25 to 4096, in the sweep's form", check.text(), "", taken, true, ours.finish(),
           naive.finish()}};
}

std::vector<Row> filter_rows(const oracle::HardCase& hard, std::size_t points, std::uint64_t seed) {
  Random random(seed);
  Collector weight, size;
  OracleCheck check;
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
    const auto filtered = [&](Digits digits) {
      return oracle::filter(u, v, tangent, filter.radius * kernel.center.z(), digits);
    };
    const oracle::Filtered exact = filtered(Digits::quad);
    const auto where = [&] {
      return fmt::format("|a|/r {:.1e}, weight {:.3g}", u.norm() / (filter.radius * kernel.center.z()),
                         exact.weight.high);
    };
    bool worst = false;
    if (exact.weight.high > 1e-300)
      worst = weight.add(disc.weight, exact.weight, oracle::ulp<double>(exact.weight.high), 0.0, where);
    worst |= size.add(disc.size, exact.size, oracle::ulp<double>(exact.size.high), 0.0, where);
    if (!check.wants(i, worst)) continue;
    const oracle::Filtered fifty = filtered(Digits::fifty);
    if (exact.weight.high > 1e-300)
      check.include(exact.weight, fifty.weight, oracle::ulp<double>(exact.weight.high));
    check.include(exact.size, fifty.size, oracle::ulp<double>(exact.size.high));
  }
  const std::size_t weights = weight.points(), sizes = size.points();
  std::vector<Row> rows;
  if (weights > 0)
    rows.push_back({"filter: weight", hard.name, "double", case_range, check.text(), "", weights, false,
                    weight.finish(), std::nullopt});
  if (sizes > 0)
    rows.push_back({"filter: size", hard.name, "double", case_range, check.text(), "", sizes, false,
                    size.finish(), std::nullopt});
  return rows;
}

}  // namespace

void add_fragment_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs) {
  jobs.push_back([points, seed] { return fragment_rows(nullptr, points, seed); });
  for (const oracle::HardCase& hard : oracle::hard_cases())
    jobs.push_back([&hard, points, seed] { return fragment_rows(&hard, points, seed); });
}

void add_crossing_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs) {
  for (const double slope : {0.0, -4.0, -8.0}) {
    jobs.push_back([=] { return crossing_rows<double>(slope, points, seed); });
    jobs.push_back([=] { return crossing_rows<float>(slope, points, seed); });
  }
}

void add_filter_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs) {
  for (const oracle::HardCase& hard : oracle::hard_cases())
    jobs.push_back([&hard, points, seed] { return filter_rows(hard, points, seed); });
}

}  // namespace swept::stability
