#include "tools/stability_table.h"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace swept::stability {
namespace {

std::string number(double value) {
  if (value == 0.0) return "0";
  return value >= 0.01 && value < 1e5 ? fmt::format("{:.3g}", value) : fmt::format("{:.1e}", value);
}

/// A bar would end the cell.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

/// Worst and percentile; what is not finite is worse than any number.
std::string ulps(const Errors& errors) {
  std::string text = fmt::format("{} / {}", number(errors.worst_ulp), number(errors.p999_ulp));
  if (errors.not_finite > 0) text += fmt::format(", {} not finite", errors.not_finite);
  return text;
}

nlohmann::ordered_json json_of(const Errors& errors) {
  return {{"worst_ulp", errors.worst_ulp},
          {"p999_ulp", errors.p999_ulp},
          {"worst_absolute", errors.worst_absolute},
          {"not_finite", errors.not_finite},
          {"where", errors.where}};
}

struct Summary {
  double ours = 0.0, naive = 0.0, share = 0.0;
  bool has_bound = false;
  std::size_t points = 0, not_finite = 0, naive_not_finite = 0;
};

}  // namespace

Errors Collector::finish() {
  if (!ulps_.empty()) {
    const auto place =
        ulps_.begin() + static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(ulps_.size() - 1));
    std::nth_element(ulps_.begin(), place, ulps_.end());
    errors_.p999_ulp = *place;
  }
  ulps_.clear();
  return errors_;
}

std::string OracleCheck::text() const {
  return fmt::format("113 bits; 50 digits at {} points, {} ulp apart", points_, number(farthest_));
}

std::string describe_branches(const std::map<std::string, std::size_t>& counts) {
  std::size_t total = 0;
  for (const auto& [name, count] : counts) total += count;
  std::string text;
  for (const auto& [name, count] : counts)
    text += fmt::format("{}{} {:.3g}%", text.empty() ? "" : ", ", name,
                        100.0 * static_cast<double>(count) / static_cast<double>(total));
  return text;
}

std::string to_markdown(const std::vector<Row>& rows) {
  std::vector<std::string> order;
  std::map<std::string, Summary> summaries;
  for (const Row& row : rows) {
    const std::string key = fmt::format("{} | {}", row.formula, row.number);
    if (!summaries.count(key)) order.push_back(key);
    Summary& summary = summaries[key];
    summary.points += row.points;
    summary.ours = std::max(summary.ours, row.ours.worst_ulp);
    summary.share = std::max(summary.share, row.ours.worst_share);
    summary.has_bound = summary.has_bound || row.has_bound;
    summary.not_finite += row.ours.not_finite;
    if (!row.naive) continue;
    summary.naive = std::max(summary.naive, row.naive->worst_ulp);
    summary.naive_not_finite += row.naive->not_finite;
  }
  std::string text =
      "| formula | type | points | worst, ulp | of the stated bound | not finite | naive formula: worst, ulp "
      "| "
      "not finite |\n|---|---|---|---|---|---|---|---|\n";
  for (const std::string& key : order) {
    const Summary& s = summaries[key];
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", key, s.points, number(s.ours),
                        s.has_bound ? number(s.share) : "", s.not_finite,
                        s.naive > 0.0 || s.naive_not_finite > 0 ? number(s.naive) : "", s.naive_not_finite);
  }
  text +=
      "\n| formula | case | type | range | points | worst / 99.9th percentile, ulp | worst, absolute | of "
      "the "
      "stated bound | worst at | branch | oracle | naive: worst / 99.9th, ulp |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Row& row : rows)
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", row.formula,
                        row.hard_case, row.number, cell(row.range), row.points, ulps(row.ours),
                        number(row.ours.worst_absolute), row.has_bound ? number(row.ours.worst_share) : "",
                        cell(row.ours.where), row.branches, row.oracle, row.naive ? ulps(*row.naive) : "");
  return text;
}

std::string to_json(const std::vector<Row>& rows, std::size_t points, std::uint64_t seed) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    nlohmann::ordered_json entry = {{"formula", row.formula}, {"case", row.hard_case},
                                    {"type", row.number},     {"range", row.range},
                                    {"points", row.points},   {"branches", row.branches},
                                    {"oracle", row.oracle},   {"ours", json_of(row.ours)}};
    if (row.has_bound) entry["ours"]["worst_share_of_bound"] = row.ours.worst_share;
    if (row.naive) entry["naive"] = json_of(*row.naive);
    list.push_back(std::move(entry));
  }
  const nlohmann::ordered_json all = {{"points_per_row", points}, {"seed", seed}, {"rows", std::move(list)}};
  return all.dump(1) + "\n";
}

}  // namespace swept::stability
