// Plain text: one point a line, numbers parted by blanks, commas or semicolons; comments after # or //.
#include <algorithm>

#include "splat/io/attributes.h"
#include "splat/io/file_bytes.h"
#include "splat/io/read_formats.h"
#include "splat/io/text_layout.h"

namespace swept {
namespace {

constexpr const char* kSeparators = ",;";
/// What is known of a column takes a hundred times what its number takes in the file.
constexpr std::size_t kMostColumns = std::size_t{1} << 20;

/// The rows of the file, one after the other.
class Rows {
 public:
  Rows(std::string_view text, std::size_t lines_before) : lines_(text, kSeparators), before_(lines_before) {}

  /// Moves to the next line with data; false at the end of the file.
  bool next() {
    tokens.clear();
    while (tokens.empty() && lines_.next_line()) {
      for (auto token = lines_.next_token(); !token.empty() && token.substr(0, 2) != "//";
           token = lines_.next_token()) {
        tokens.push_back(token);
      }
    }
    return !tokens.empty();
  }
  [[nodiscard]] std::string line() const { return "line " + std::to_string(before_ + lines_.line_number()); }

  std::vector<std::string_view> tokens;

 private:
  LineScanner lines_;
  std::size_t before_;
};

/// The columns by the names of the header, and by number.
std::vector<Column> columns_of(const TextHead& head, std::size_t count) {
  std::vector<Column> columns;
  for (std::size_t c = 0; c < count; ++c) {
    const std::string number = std::to_string(c + 1);
    columns.push_back({head.names.empty() ? number : head.names[c], 0.0, number});
  }
  return columns;
}

/// Reads the row in `rows` and all after it. Of columns that are not needed, nothing.
Result<std::vector<std::vector<double>>> read_rows(const std::string& path, Rows& rows,
                                                   const std::vector<Column>& columns,
                                                   const std::vector<bool>& needed) {
  std::vector<std::vector<double>> values(columns.size());
  do {
    if (rows.tokens.size() != columns.size()) {
      return Error{path, rows.line(),
                   "has " + std::to_string(rows.tokens.size()) + " numbers, the first line has " +
                       std::to_string(columns.size())};
    }
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (!needed[c]) continue;
      const std::optional<double> value = parse_number(rows.tokens[c]);
      if (!value) return Error{path, rows.line() + ", " + columns[c].name, not_a_number(rows.tokens[c])};
      values[c].push_back(*value);
    }
  } while (rows.next());
  return values;
}

}  // namespace

Result<PointSet> read_xyz(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  TextHead head = read_text_head(bytes, kSeparators);
  Rows rows(bytes.substr(head.data), head.lines);
  if (!rows.next()) return Error{path, "", "has no points"};
  if (rows.tokens.size() > kMostColumns) {
    return Error{path, rows.line(),
                 "has " + std::to_string(rows.tokens.size()) + " numbers, at most 1048576 are read"};
  }
  const std::string_view first = bytes.substr(head.data);
  if (has_decimal_commas(first.substr(0, first.find('\n')))) {
    return Error{path, rows.line(), "seems to have commas for decimal points, which are not read"};
  }
  std::string passed_by;
  if (const Status s = head.fit_names(path, rows.tokens.size(), passed_by); !s) return s.error();
  std::vector<Column> columns = columns_of(head, rows.tokens.size());
  // An empty name only leaves an attribute out.
  const bool mapped = std::any_of(options.attributes.begin(), options.attributes.end(),
                                  [](const auto& entry) { return !entry.second.empty(); });
  ReadOptions with_positions = options;
  const bool infer = head.names.empty() && !mapped;
  std::vector<bool> needed(columns.size(), true);
  AttributePlan plan;
  if (infer) {
    // The names of messages until more is known.
    for (std::size_t c = 0; c < std::min<std::size_t>(3, columns.size()); ++c) columns[c].name = "xyz"[c];
    if (!is_known_width(columns.size())) {
      return Error{
          path, rows.line(),
          "has " + std::to_string(columns.size()) +
              " numbers; 3, 4, 6, 7 and 9 are understood, others need a header line or named attributes"};
    }
  } else {
    if (head.names.empty()) with_positions.attributes.insert({"position", "1,2,3"});
    const Result<AttributePlan> planned = plan_attributes(path, columns, with_positions);
    if (!planned) return planned.error();
    plan = *planned;
    needed = plan.needed(columns.size());
  }

  const auto values = read_rows(path, rows, columns, needed);
  if (!values) return values.error();
  const std::size_t count = values->at(plan.position[0]).size();
  if (head.count && *head.count != count) {
    return Error{
        path, "header",
        "the file says it has " + std::to_string(*head.count) + ", and has " + std::to_string(count)};
  }
  std::string assumed;
  if (infer) {
    const auto names = infer_text_columns(path, *values, assumed);
    if (!names) return names.error();
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c].name = (*names)[c];
    const Result<AttributePlan> planned = plan_attributes(path, columns, options);
    if (!planned) return planned.error();
    plan = *planned;
  }
  Result<PointSet> set = assemble_points(path, columns, plan, *values, {}, options);
  if (!set) return set;
  std::vector<std::string>& said = set->report.assumed;
  if (!assumed.empty()) said.insert(said.begin(), assumed);
  if (!passed_by.empty()) said.push_back(passed_by);
  return set;
}

}  // namespace swept
