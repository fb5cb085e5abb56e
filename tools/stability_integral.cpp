#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include <fmt/core.h>

#include "abuffer/resolve/members.h"
#include "splat/kernel/kernel_integral.h"
#include "tests/oracle/hard_kernels.h"
#include "tests/oracle/naive.h"
#include "tools/stability_rows.h"

namespace swept::stability {
namespace {

using oracle::Random;
using oracle::uniform;

struct IntegralCase {
  const char* name;
  const char* range;
  /// `far`: how far out ends may be, where that is not the case's own.
  std::pair<double, double> (*make)(Random&, double far);
};

double log_uniform(Random& random, double low, double high) { return std::exp2(uniform(random, low, high)); }

const IntegralCase cases[] = {
    {"no motion", "span 0",
     [](Random& r, double far) {
       const double y = uniform(r, -far, far);
       return std::pair{y, y};
     }},
    {"minute motion", "spans 2⁻⁶⁰ to 2⁻⁵",
     [](Random& r, double far) {
       const double y = uniform(r, -far, far);
       return std::pair{y, y + log_uniform(r, -60.0, -5.0)};
     }},
    {"about the series' switch", "span · (1 + 0.8 |y|) from 0.6 to 1.2",
     [](Random& r, double far) {
       const double y = uniform(r, -far, far);
       return std::pair{y, y + uniform(r, 0.6, 1.2) / (1.0 + 0.8 * std::abs(y))};
     }},
    {"astride the peak", "ends to 6 on either side",
     [](Random& r, double) {
       return std::pair{-uniform(r, 0.0, 6.0), uniform(r, 0.0, 6.0)};
     }},
    {"beside the peak", "nearer end 2⁻³⁰ to 2, spans to 4",
     [](Random& r, double) {
       const double y = log_uniform(r, -30.0, 1.0);
       return std::pair{y, y + uniform(r, 0.0, 4.0)};
     }},
    {"in the tail", "nearer end 2 and more, spans 2⁻⁶ to 2⁶",
     [](Random& r, double far) {
       const double y = uniform(r, 2.0, far);
       return std::pair{y, y + log_uniform(r, -6.0, 6.0)};
     }},
    {"vast motion", "spans 2⁶ to 2¹⁰⁰",
     [](Random& r, double far) {
       const double y = uniform(r, -far, far);
       return std::pair{y, y + log_uniform(r, 6.0, 100.0)};
     }},
};

template <class T>
std::string branch_name(T a, T b) {
  switch (gaussian_branch(a, b)) {
    case GaussianBranch::underflow:
      return "underflow";
    case GaussianBranch::series:
      return "series";
    case GaussianBranch::astride:
      return "astride";
    case GaussianBranch::one_sided:
      return "one-sided";
  }
  return "";
}

oracle::Exact fifty(double a, double b) { return oracle::mean_gaussian(a, b, oracle::Digits::fifty); }
oracle::Exact quad(double a, double b) { return oracle::mean_gaussian(a, b, oracle::Digits::quad); }

template <class T>
std::vector<Row> mean_row(const IntegralCase& hard, std::size_t points, std::uint64_t seed) {
  Random random(seed);
  Collector ours, naive;
  OracleCheck check;
  std::map<std::string, std::size_t> branches;
  const double far = sizeof(T) == 4 ? 9.3 : 26.6;  // where exp(−y²) is the smallest normal number
  for (std::size_t i = 0; i < points; ++i) {
    const auto [exact_a, exact_b] = hard.make(random, far);
    T a = static_cast<T>(exact_a), b = static_cast<T>(exact_b);
    if (random() % 2) std::swap(a = -a, b = -b);
    const oracle::Exact exact = quad(a, b);
    if (!oracle::normal<T>(exact)) continue;
    ++branches[branch_name(a, b)];
    const double ulp = oracle::ulp<T>(exact.high);
    const double bound = sizeof(T) == 4 ? 3.0 : 4.0;
    const auto where = [&] { return fmt::format("[{:.9g}, {:.9g}]", double{a}, double{b}); };
    const T mean = mean_gaussian(a, b);
    const bool worst = ours.add(mean, exact, ulp, oracle::error(mean, exact) / ulp / bound, where);
    naive.add(naive::mean_gaussian(a, b), exact, ulp, 0.0, where);
    if (check.wants(i, worst)) check.include(exact, fifty(a, b), ulp);
  }
  const std::size_t taken = ours.points();
  return {{"mean of exp(−y²)", hard.name, type_name<T>, fmt::format("|y| to {}, {}", far, hard.range),
           check.text(), describe_branches(branches), taken, true, ours.finish(), naive.finish()}};
}

/// Where that weight lies, in units of the span. Its exact value is a difference that loses digits over short
/// spans: those are left to 50 digits alone.
std::vector<Row> centroid_row(const IntegralCase& hard, std::size_t points, std::uint64_t seed) {
  constexpr double far = 7.07, bound = 7e-5, unit = 0x1p-53;
  Random random(seed);
  Collector ours, naive;
  OracleCheck check;
  for (std::size_t i = 0; i < points; ++i) {
    auto [a, b] = hard.make(random, far);
    if (random() % 2) std::swap(a = -a, b = -b);
    if (!(a < b) || !oracle::normal<double>(quad(a, b))) continue;
    const bool is_short = b - a < 0x1p-10;
    const oracle::Exact exact =
        oracle::gaussian_centroid(a, b, is_short ? oracle::Digits::fifty : oracle::Digits::quad);
    const auto where = [first = a, last = b] { return fmt::format("[{:.9g}, {:.9g}]", first, last); };
    const double centroid = gaussian_centroid(a, b);
    const bool worst = ours.add(centroid, exact, unit, oracle::error(centroid, exact) / bound, where);
    naive.add(naive::gaussian_centroid(a, b), exact, unit, 0.0, where);
    if (!is_short && check.wants(i, worst)) check.include(exact, oracle::gaussian_centroid(a, b), unit);
  }
  const std::size_t taken = ours.points();
  if (taken == 0) return {};
  return {{"centroid of exp(−y²), of the span", hard.name, "double",
           fmt::format("|y| to √50, {}", hard.range), check.text(), "", taken, true, ours.finish(),
           naive.finish()}};
}

/// The sweep's own, as built for every instruction set: |y| ≤ √50, the most that a cut-off allows.
std::vector<Row> sweep_rows(const IntegralCase& hard, std::size_t points, std::uint64_t seed) {
  constexpr double far = 7.07;
  const auto builds = interval_math_builds();
  std::vector<Collector> errors(builds.size());
  std::vector<double> apart(builds.size(), 0.0);
  Random random(seed);
  OracleCheck check;
  std::map<std::string, std::size_t> branches;
  FragmentArrays fragments;
  fragments.ensure(member_lanes);
  MemberSet members;
  for (std::size_t i = 0; i < points; i += member_lanes) {
    members.clear();
    std::array<std::pair<double, double>, member_lanes> ends;
    std::array<bool, member_lanes> series;
    for (std::size_t lane = 0; lane < member_lanes; ++lane) {
      auto [first, last] = hard.make(random, far);
      first = std::clamp(first, -far, far);
      last = std::clamp(last, first, far);
      if (random() % 2) std::swap(first = -first, last = -last);
      const float a = static_cast<float>(first), span = static_cast<float>(last - first);
      // The series sees a middle in float and this span about it, the rest the ends as they are.
      const float middle = a + 0.5f * span;
      series[lane] = span <= 0.5f && span * std::abs(middle) <= 1.0f;
      ends[lane] = series[lane] ? std::pair{middle - 0.5 * double{span}, middle + 0.5 * double{span}}
                                : std::pair{double{a}, double{a} + double{span}};
      fragments.t_begin[0] = 0;
      fragments.t_end[0] = shutter_close;
      fragments.peak[0] = fragments.z[0] = 1.0f;
      fragments.y[0] = a;
      fragments.rate[0] = span;
      fragments.z_rate[0] = 0.0f;
      members.push(fragments, 0, {});
    }
    std::vector<std::array<float, member_lanes>> means(builds.size());
    for (std::size_t k = 0; k < builds.size(); ++k)
      (void)builds[k].sum_over(members.view(), 0, shutter_close, means[k].data());
    for (std::size_t lane = 0; lane < member_lanes; ++lane) {
      const auto [a, b] = ends[lane];
      const oracle::Exact exact = quad(a, b);
      ++branches[series[lane] ? "vector series" : "mean_gaussian"];
      const double ulp = oracle::ulp<float>(exact.high);
      const auto where = [first = a, last = b] { return fmt::format("[{:.9g}, {:.9g}]", first, last); };
      bool worst = false;
      for (std::size_t k = 0; k < builds.size(); ++k) {
        const float mean = means[k][lane];
        worst |= errors[k].add(mean, exact, ulp, oracle::error(mean, exact) / ulp / 5.0, where);
        apart[k] = std::max(apart[k], std::abs(double{mean} - double{means[0][lane]}) / ulp);
      }
      if (check.wants(i + lane, worst)) check.include(exact, fifty(a, b), ulp);
    }
  }
  std::vector<Row> rows;
  for (std::size_t k = 0; k < builds.size(); ++k) {
    std::string branch = describe_branches(branches);
    if (k > 0) branch += fmt::format("; from scalar {:.3g} ulp", apart[k]);
    const std::size_t taken = errors[k].points();
    rows.push_back({fmt::format("the same in the sweep, {}", builds[k].name), hard.name, "float",
                    fmt::format("|y| to √50, {}", hard.range), check.text(), branch, taken, true,
                    errors[k].finish(), std::nullopt});
  }
  return rows;
}

}  // namespace

void add_integral_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs) {
  for (const IntegralCase& hard : cases)
    jobs.push_back([&hard, points, seed] { return mean_row<double>(hard, points, seed); });
  for (const IntegralCase& hard : cases)
    jobs.push_back([&hard, points, seed] { return mean_row<float>(hard, points, seed); });
  for (const IntegralCase& hard : cases)
    jobs.push_back([&hard, points, seed] { return sweep_rows(hard, points, seed); });
  for (const IntegralCase& hard : cases)
    jobs.push_back([&hard, points, seed] { return centroid_row(hard, points, seed); });
}

}  // namespace swept::stability
