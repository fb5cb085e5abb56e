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
  template <class Where>
  void add(double value, oracle::Exact exact, double ulp, double share, Where where) {
    const double error = oracle::error(value, exact);
    if (!(error <= std::numeric_limits<double>::max())) {
      ++errors_.not_finite;
      if (errors_.not_finite == 1 && ulps_.empty()) errors_.where = where();
      return;
    }
    const double ulps = error / ulp;
    ulps_.push_back(static_cast<float>(std::min(ulps, 1e38)));
    errors_.worst_absolute = std::max(errors_.worst_absolute, error);
    errors_.worst_share = std::max(errors_.worst_share, share);
    if (ulps <= errors_.worst_ulp) return;
    errors_.worst_ulp = ulps;
    errors_.where = where();
  }
  [[nodiscard]] std::size_t points() const { return ulps_.size() + errors_.not_finite; }
  [[nodiscard]] Errors finish();

 private:
  Errors errors_;
  std::vector<float> ulps_;
};

/// "series 61%, astride 39%".
[[nodiscard]] std::string describe_branches(const std::map<std::string, std::size_t>& counts);

[[nodiscard]] std::string to_markdown(const std::vector<Row>& rows);
[[nodiscard]] std::string to_json(const std::vector<Row>& rows, std::size_t points, std::uint64_t seed);

}  // namespace swept::stability
