#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include <fmt/core.h>

#include "abuffer/members.h"
#include "splat/kernel_integral.h"
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
  /// `far`: where exp(−y²) is the smallest normal number.
  std::pair<double, double> (*make)(Random&, double far);
};

double log_uniform(Random& random, double low, double high) { return std::exp2(uniform(random, low, high)); }

const IntegralCase cases[] = {
    {"no motion", "y up to the last normal exp(−y²), span 0",
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
    {"in the tail", "nearer end 2 to the last normal one, spans 2⁻⁶ to 2⁶",
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

template <class T>
constexpr const char* type_name = sizeof(T) == 4 ? "float" : "double";

template <class T>
void add_mean_row(const IntegralCase& hard, std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  Random random(seed);
  Collector ours, naive;
  std::map<std::string, std::size_t> branches;
  for (std::size_t i = 0; i < points; ++i) {
    const auto [exact_a, exact_b] = hard.make(random, sizeof(T) == 4 ? 9.3 : 26.6);
    T a = static_cast<T>(exact_a), b = static_cast<T>(exact_b);
    if (random() % 2) std::swap(a = -a, b = -b);
    const oracle::Exact exact = oracle::mean_gaussian(a, b, oracle::Digits::quad);
    if (!oracle::normal<T>(exact)) continue;
    ++branches[branch_name(a, b)];
    const double ulp = oracle::ulp<T>(exact.high);
    const double bound = sizeof(T) == 4 ? 3.0 : 4.0;
    const auto where = [&] { return fmt::format("[{:.9g}, {:.9g}]", double{a}, double{b}); };
    const T mean = mean_gaussian(a, b);
    ours.add(mean, exact, ulp, oracle::error(mean, exact) / ulp / bound, where);
    naive.add(naive::mean_gaussian(a, b), exact, ulp, 0.0, where);
  }
  const std::size_t taken = ours.points();
  rows.push_back({"mean of exp(−y²)", hard.name, type_name<T>, hard.range, "113 bits",
                  describe_branches(branches), taken, true, ours.finish(), naive.finish()});
}

/// The sweep's own: |y| ≤ √50, the most that a cut-off allows, and spans up to the longest it asks for.
void add_sweep_row(std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  Random random(seed);
  Collector ours;
  std::map<std::string, std::size_t> branches;
  FragmentArrays fragment;
  fragment.ensure(member_lanes);
  for (std::size_t i = 0; i < points; ++i) {
    // On a grid of 2⁻¹⁶, for the member's y, rate and middle to be exact.
    const auto on_grid = [](double y) { return static_cast<float>(std::round(y * 65536.0) / 65536.0); };
    const float a = on_grid(uniform(random, -7.0, 7.0)),
                span = on_grid(random() % 4 ? uniform(random, 0.0, 0.5) : uniform(random, 0.0, 8.0));
    const float b = a + span;
    const oracle::Exact exact = oracle::mean_gaussian(a, b, oracle::Digits::quad);
    if (!oracle::normal<float>(exact)) continue;
    fragment.t_begin[0] = 0.0f;
    fragment.t_end[0] = 1.0f;
    fragment.y[0] = a;
    fragment.rate[0] = span;
    fragment.peak[0] = 1.0f;
    fragment.z[0] = 1.0f;
    fragment.z_rate[0] = 0.0f;
    MemberSet members;
    members.push(fragment, 0, {});
    float mean[member_lanes];
    (void)interval_math_builds().back().sum_over(members.view(), 0.0f, 1.0f, mean);
    const double middle = 0.5 * (double{a} + double{b});
    ++branches[GaussianSeries<float>::holds(static_cast<float>(middle), span) ? "vector series"
                                                                              : "mean_gaussian"];
    // 4 ulp beyond what rounding y² costs: half an ulp of it in the exponent.
    const double bound = 4.0 + middle * middle;
    const double ulp = oracle::ulp<float>(exact.high);
    ours.add(mean[0], exact, ulp, oracle::error(mean[0], exact) / ulp / bound,
             [&] { return fmt::format("[{:.9g}, {:.9g}]", double{a}, double{b}); });
  }
  const std::size_t taken = ours.points();
  rows.push_back({"mean of exp(−y²), in the sweep", "all", "float", "|y| ≤ 7, spans to 8", "113 bits",
                  describe_branches(branches), taken, true, ours.finish(), std::nullopt});
}

}  // namespace

void add_integral_rows(std::size_t points, std::uint64_t seed, std::vector<Row>& rows) {
  for (const IntegralCase& hard : cases) add_mean_row<double>(hard, points, seed, rows);
  for (const IntegralCase& hard : cases) add_mean_row<float>(hard, points, seed, rows);
  add_sweep_row(points, seed, rows);
}

}  // namespace swept::stability
