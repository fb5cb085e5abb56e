// Rows of the edges of moving triangles: where a ray crosses them in time.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include <fmt/core.h>

#include "splat/interval/bernstein.h"
#include "tests/oracle/edge_roots.h"
#include "tests/oracle/hard_kernels.h"
#include "tests/oracle/of_roots.h"
#include "tools/stability_rows.h"

namespace swept::stability {
namespace {

using oracle::Digits;
using oracle::Exact;
using oracle::Random;
using oracle::uniform;

double slope_at(const Bernstein& p, double t) {
  Bernstein slope;
  slope.degree = p.degree - 1;
  for (std::size_t k = 0; k < static_cast<std::size_t>(p.degree); ++k)
    slope.c[k] = p.degree * (p.c[k + 1] - p.c[k]);
  return slope.at(t);
}

/// Two roots of the quadratic formula on powers of t, in order.
SignChanges naive_quadratic(const Bernstein& p) {
  const double a = p.c[0] - 2.0 * p.c[1] + p.c[2], b = 2.0 * (p.c[1] - p.c[0]), c = p.c[0];
  const double root = std::sqrt(b * b - 4.0 * a * c);
  double t[2] = {(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)};
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  SignChanges changes;
  for (const double at : t)
    if (at > 0.0 && at < 1.0) changes.at[static_cast<std::size_t>(changes.count++)] = at;
  return changes;
}

struct Case {
  const char* name;
  double apart;  ///< of two of the roots; below 0: they are anywhere
};
constexpr Case cases[] = {{"roots anywhere", -1.0},
                          {"two roots 10⁻³ apart", 1e-3},
                          {"two roots 10⁻⁶ apart", 1e-6},
                          {"two roots 10⁻⁸ apart", 1e-8},
                          {"a double root, rounded", 0.0}};

enum class Solver { quadratic, cutting, closed_quartic };

std::vector<Row> edge_rows(Solver solver, const Case& of, std::size_t points, std::uint64_t seed) {
  Random random(seed);
  OracleCheck check;
  Collector ours, naive;
  std::map<std::string, std::size_t> branches;
  const int degree = solver == Solver::quadratic ? 2 : 4;
  for (std::size_t i = 0; i < points; ++i) {
    std::vector<double> roots;
    for (int k = 0; k < degree; ++k) roots.push_back(uniform(random, -0.5, 1.5));
    if (of.apart >= 0.0) {
      roots[0] = uniform(random, 0.05, 0.95);
      roots[1] = roots[0] + of.apart;
    }
    const Bernstein p = of_roots(roots, oracle::magnitude(random, -6.0, 6.0));
    const std::vector<Exact> exact = oracle::sign_changes(p.c.data(), degree, Digits::quad);
    const SignChanges found = solver == Solver::cutting ? sign_changes_by_cutting(p) : sign_changes_closed(p);
    const SignChanges first_written = solver == Solver::quadratic ? naive_quadratic(p) : SignChanges{};
    // Numbers that rounding leaves no sign: two changes may be missed or seen there, and only quadratics
    // tell.
    const double noise = solver == Solver::quadratic ? 0.0 : 0x1p-42 * p.largest();
    if (static_cast<std::size_t>(found.count) != exact.size()) {
      double least = p.largest();
      for (int k = 1; k < 4096; ++k) least = std::min(least, std::abs(p.at(k / 4096.0)));
      for (const double root : roots)
        if (root > 0.0 && root < 1.0) least = std::min(least, std::abs(p.at(root + 0.5 * of.apart)));
      if (noise > 0.0 && least <= noise) {
        ++branches["within noise"];
        continue;
      }
    }
    ++branches[fmt::format("{} changes", exact.size())];
    for (std::size_t k = 0; k < exact.size(); ++k) {
      const double t = exact[k].high, ulp = oracle::ulp<double>(t), slope = std::abs(slope_at(p, t));
      const auto where = [&] { return fmt::format("t {:.17g}, largest {:.1e}", t, p.largest()); };
      const double got = k < static_cast<std::size_t>(found.count) ? found.at[k] : std::nan("");
      // A quadratic's are right to a few ulp; others by what noise in the coefficients moves them.
      const double bound =
          solver == Solver::quadratic ? 8.0 * ulp : 8.0 * ulp + 0x1p-46 * p.largest() / slope;
      const bool worst = ours.add(got, exact[k], ulp, oracle::error(got, exact[k]) / bound, where);
      if (solver == Solver::quadratic)
        naive.add(k < static_cast<std::size_t>(first_written.count) ? first_written.at[k] : std::nan(""),
                  exact[k], ulp, 0.0, where);
      if (!OracleCheck::wants(i, worst)) continue;
      const std::vector<Exact> fifty = oracle::sign_changes(p.c.data(), degree, Digits::fifty);
      if (k < fifty.size()) check.include(exact[k], fifty[k], ulp);
    }
  }
  const std::size_t taken = ours.points();
  const char* formula = solver == Solver::quadratic ? "edge of a triangle on lines: when it passes a ray"
                        : solver == Solver::cutting ? "the same on parabolas, by cutting"
                                                    : "the same on parabolas, in closed form";
  Row row{formula,       of.name,
          "double",      fmt::format("degree {}, roots in [−½, 1½]", degree),
          check.text(),  describe_branches(branches),
          taken,         true,
          ours.finish(), {}};
  if (solver == Solver::quadratic) row.naive = naive.finish();
  return {row};
}

}  // namespace

void add_edge_jobs(std::size_t points, std::uint64_t seed, std::vector<Job>& jobs) {
  for (const Case& of : cases) {
    jobs.push_back([&of, points, seed] { return edge_rows(Solver::quadratic, of, points, seed); });
    // Exact roots of degree 4 take long.
    for (const Solver solver : {Solver::cutting, Solver::closed_quartic})
      jobs.push_back([&of, solver, points, seed] {
        return edge_rows(solver, of, std::max<std::size_t>(1, points / 8), seed);
      });
  }
}

}  // namespace swept::stability
