// Rows of the stability table: how far a formula's results are from exact ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/oracle/oracle.h"

namespace swept::stability {

struct Errors {
  double worst_ulp = 0.0, p999_ulp = 0.0;  ///< p999: 99.9th percentile
  double worst_absolute = 0.0;
  double worst_share = 0.0;    ///< of the stated error bound; only of the library's formulas
  std::size_t not_finite = 0;  ///< results that are NaN or infinite where the exact ones are finite
  std::string where;           ///< inputs of the worst
};

/// One formula on one hard case, the library's beside the naive one.
struct Row {
  std::string formula, hard_case, number, range, oracle;
  std::string branches;  ///< the library's branches and the share of points that took each
  std::size_t points = 0;
  bool has_bound = false;
  Errors ours;
  std::optional<Errors> naive;
};

/// Collects the errors of one column.
class Collector {
 public:
  /// `value` against the exact one, in units of `ulp`; `share` of the bound. `where()` names the inputs.
  /// Returns whether it is the worst so far.
  template <class Where>
  bool add(double value, oracle::Exact exact, double ulp, double share, Where where) {
    const double error = oracle::error(value, exact);
    if (!(error <= std::numeric_limits<double>::max())) {
      ++errors_.not_finite;
      if (errors_.not_finite == 1 && ulps_.empty()) errors_.where = where();
      return true;
    }
    const double ulps = error / ulp;
    ulps_.push_back(static_cast<float>(std::min(ulps, 1e38)));
    errors_.worst_absolute = std::max(errors_.worst_absolute, error);
    errors_.worst_share = std::max(errors_.worst_share, share);
    if (ulps <= errors_.worst_ulp) return false;
    errors_.worst_ulp = ulps;
    errors_.where = where();
    return true;
  }
  [[nodiscard]] std::size_t points() const { return ulps_.size() + errors_.not_finite; }
  [[nodiscard]] Errors finish();

 private:
  Errors errors_;
  std::vector<float> ulps_;
};

/// Rows are computed against 113 bits, which is quick. The points that decide a row, each worst one so far,
/// and every thousandth are computed with 50 digits as well.
class OracleCheck {
 public:
  [[nodiscard]] static bool wants(std::size_t point, bool worst) { return worst || point % 1000 == 0; }
  /// The two results; their distance counts in units of `ulp`.
  void include(oracle::Exact quad, oracle::Exact fifty, double ulp) {
    ++points_;
    const double distance = std::abs((quad.high - fifty.high) + (quad.low - fifty.low)) / ulp;
    if (!(distance <= farthest_)) farthest_ = distance;
  }
  [[nodiscard]] std::size_t points() const { return points_; }
  [[nodiscard]] std::string text() const;

 private:
  std::size_t points_ = 0;
  double farthest_ = 0.0;
};

/// "series 61%, astride 39%".
[[nodiscard]] std::string describe_branches(const std::map<std::string, std::size_t>& counts);

[[nodiscard]] std::string to_markdown(const std::vector<Row>& rows);
[[nodiscard]] std::string to_json(const std::vector<Row>& rows, std::size_t points, std::uint64_t seed);

}  // namespace swept::stability
