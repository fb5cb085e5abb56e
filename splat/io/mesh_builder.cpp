#include "splat/io/mesh_builder.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace swept {

std::optional<std::int64_t> parse_integer(std::string_view token) {
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (code != std::errc{} || end != token.data() + token.size()) return std::nullopt;
  return value;
}

Status MeshBuilder::add_vertex(std::string_view x) {
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string_view token = c == 0 ? x : lines.next_token();
    const std::optional<double> value = parse_number(token);
    if (!value)
      return fail(columns_[c].name,
                  token.empty() ? "the vertex has fewer than three numbers" : not_a_number(token));
    values_[c].push_back(*value);
  }
  std::size_t count = 0;
  for (auto token = lines.next_token(); !token.empty(); token = lines.next_token(), ++count) {
    const std::optional<double> value = parse_number(token);
    if (!value) return fail("number " + std::to_string(count + 4) + " of the vertex", not_a_number(token));
    further_.push_back(*value);
  }
  least_ = std::min(least_, count);
  most_ = std::max(most_, count);
  return Done{};
}

void MeshBuilder::add_column(const std::string& name, std::vector<double> values) {
  columns_.push_back({name});
  values_.push_back(std::move(values));
}

std::optional<std::size_t> MeshBuilder::further_numbers() const {
  if (vertex_count() == 0) return 0;
  if (least_ != most_) return std::nullopt;
  return most_;
}

Error MeshBuilder::fail(const std::string& what, const std::string& reason) const {
  return {path_, "line " + std::to_string(lines.line_number()) + ", " + what, reason};
}

Result<PointSet> MeshBuilder::finish(const std::vector<std::string>& further, const ReadOptions& options) {
  for (std::size_t k = 0; k < further.size(); ++k) {
    if (further[k].empty()) continue;
    std::vector<double> column;
    column.reserve(vertex_count());
    for (std::size_t i = k; i < further_.size(); i += further.size()) column.push_back(further_[i]);
    add_column(further[k], std::move(column));
  }
  const Result<AttributePlan> plan = plan_attributes(path_, columns_, options);
  if (!plan) return plan.error();
  return assemble_points(path_, columns_, *plan, values_, std::move(triangles), options,
                         std::move(texture_corners));
}

}  // namespace swept
