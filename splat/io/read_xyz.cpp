// Plain text: one point a line, numbers parted by blanks, commas or semicolons; comments after # or //.
#include "splat/io/attributes.h"
#include "splat/io/file_bytes.h"
#include "splat/io/read_formats.h"

namespace swept {
namespace {

/// The tokens of the next line with data; none at the end of the file.
std::vector<std::string_view> next_row(LineScanner& lines) {
  std::vector<std::string_view> row;
  while (row.empty() && lines.next_line()) {
    for (auto token = lines.next_token(); !token.empty() && token.substr(0, 2) != "//";
         token = lines.next_token()) {
      row.push_back(token);
    }
  }
  return row;
}

}  // namespace

Result<PointSet> read_xyz(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  LineScanner lines(bytes, ",;");
  std::vector<std::string_view> row = next_row(lines);
  if (row.empty()) return Error{path, "", "has no points"};

  std::vector<Column> columns;
  ReadOptions with_positions = options;
  if (options.attributes.empty()) {
    if (row.size() != 3 && row.size() != 6) {
      return Error{path, "line " + std::to_string(lines.line_number()),
                   "has " + std::to_string(row.size()) +
                       " numbers; x y z or x y z nx ny nz are understood, others need named attributes"};
    }
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
      if (columns.size() < row.size()) columns.push_back({name});
    }
  } else {
    for (std::size_t c = 1; c <= row.size(); ++c) columns.push_back({std::to_string(c)});
    with_positions.attributes.insert({"position", "1,2,3"});
  }
  const Result<AttributePlan> plan = plan_attributes(path, columns, with_positions);
  if (!plan) return plan.error();
  const std::vector<bool> needed = plan->needed(columns.size());

  std::vector<std::vector<double>> values(columns.size());
  for (; !row.empty(); row = next_row(lines)) {
    const std::string line = "line " + std::to_string(lines.line_number());
    if (row.size() != columns.size()) {
      return Error{path, line,
                   "has " + std::to_string(row.size()) + " numbers, the first line has " +
                       std::to_string(columns.size())};
    }
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (!needed[c]) continue;
      const std::optional<double> value = parse_number(row[c]);
      if (!value) return Error{path, line + ", " + columns[c].name, not_a_number(row[c])};
      values[c].push_back(*value);
    }
  }
  return assemble_points(path, columns, *plan, values, {}, options);
}

}  // namespace swept
