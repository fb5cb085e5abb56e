#include "splat/io/text_layout.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "splat/io/attribute_names.h"
#include "splat/io/file_bytes.h"

namespace swept {
namespace {

using Names = std::vector<std::string>;
using Values = std::vector<std::vector<double>>;

/// How far the length of a normal that was written with few digits may be from 1.
constexpr double kUnitTolerance = 0.02;
/// A longer comment names no columns.
constexpr std::size_t kMostNames = std::size_t{1} << 16;

std::vector<std::string_view> tokens_of(std::string_view line, std::string_view separators) {
  const std::string blanks = " \t\r\v\f" + std::string(separators);
  std::vector<std::string_view> tokens;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
    if (line.empty()) return tokens;
    tokens.push_back(line.substr(0, line.find_first_of(blanks)));
    line.remove_prefix(tokens.back().size());
  }
}

/// A line in its parts: before, and in, its comment.
struct Parts {
  std::string_view data, comment;
};
Parts parts_of(std::string_view line) {
  const std::size_t begin = std::min({line.find('#'), line.find("//"), line.size()});
  std::string_view comment = line.substr(begin);
  comment.remove_prefix(std::min(comment.find_first_not_of("#/ \t"), comment.size()));
  if (comment.size() > kMostNames) comment = {};
  return {line.substr(0, begin), comment};
}

/// Whether these could be the names of columns: positions are among them.
bool name_positions(const std::vector<std::string_view>& words) {
  Names names;
  for (const std::string_view word : words) names.push_back(folded(word));
  const auto named = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const std::vector<Names>& usual = attribute_names().front().usual;
  return std::any_of(usual.begin(), usual.end(), [&](const Names& position) {
    return std::all_of(position.begin(), position.end(), named);
  });
}

std::string_view unquoted(std::string_view word) {
  if (word.size() >= 2 && word.front() == '"' && word.back() == '"') return word.substr(1, word.size() - 2);
  return word;
}

std::optional<std::size_t> count_of(const std::vector<std::string_view>& tokens) {
  if (tokens.size() != 1) return std::nullopt;
  std::size_t count = 0;
  const auto [end, code] = std::from_chars(tokens[0].data(), tokens[0].data() + tokens[0].size(), count);
  if (code != std::errc{} || end != tokens[0].data() + tokens[0].size()) return std::nullopt;
  return count;
}

/// Three columns as one thing.
struct Triple {
  bool unit = true;        ///< every one of length 1 or 0, and some of length 1
  bool zero = false;       ///< all of them
  bool color = true;       ///< none negative or above 65535
  bool byte_color = true;  ///< whole numbers up to 255, more than a unit vector's
};
Triple examine(const Values& values, std::size_t first) {
  Triple triple;
  bool some_unit = false, some_above_1 = false;
  for (std::size_t i = 0; i < values[first].size(); ++i) {
    const double a = values[first][i], b = values[first + 1][i], c = values[first + 2][i];
    if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(c)) continue;
    const double length = std::hypot(a, b, c);
    some_unit = some_unit || length != 0.0;
    triple.unit = triple.unit && (length == 0.0 || std::abs(length - 1.0) <= kUnitTolerance);
    for (const double channel : {a, b, c}) {
      triple.color = triple.color && channel >= 0.0 && channel <= 65535.0;
      triple.byte_color =
          triple.byte_color && channel >= 0.0 && channel <= 255.0 && channel == std::floor(channel);
      some_above_1 = some_above_1 || channel > 1.0;
    }
  }
  triple.zero = !some_unit;
  triple.unit = triple.unit && some_unit;
  triple.byte_color = triple.byte_color && some_above_1;
  return triple;
}

bool ends_in(const std::string& path, std::string_view extension) {
  std::string end = path.substr(path.size() - std::min(path.size(), extension.size()));
  for (char& c : end) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return end == extension;
}

const Names kNormal{"nx", "ny", "nz"}, kColor{"red", "green", "blue"}, kIntensity{"intensity"};

Names joined(std::initializer_list<const Names*> parts) {
  Names names{"x", "y", "z"};
  for (const Names* part : parts) names.insert(names.end(), part->begin(), part->end());
  return names;
}

constexpr const char* kSayIt =
    "; say what they are, as in \"attributes\": {\"color\": \"4,5,6\"} or {\"normal\": \"4,5,6\"}";

}  // namespace

TextHead read_text_head(std::string_view text, std::string_view separators) {
  TextHead head;
  std::vector<std::string_view> names;
  std::size_t names_line = 0, at = 0, number = 0;
  bool plain = false;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const Parts parts = parts_of(text.substr(at, end - at));
    ++number;
    const auto data = tokens_of(parts.data, separators), comment = tokens_of(parts.comment, separators);
    if (data.empty()) {
      if (name_positions(comment) && !plain) {
        names = comment;
        names_line = number;
      }
    } else if (!head.count && count_of(data) && end + 1 < text.size()) {
      head.count = count_of(data);
    } else {
      const bool words = std::none_of(data.begin(), data.end(),
                                      [](std::string_view token) { return parse_number(token).has_value(); });
      if (plain || !words || data.size() < 3) break;
      names = data;
      names_line = number;
      plain = true;
    }
    head.lines = number;
    head.data = std::min(end + 1, text.size());
    at = head.data;
  }
  for (const std::string_view name : names) head.names.emplace_back(unquoted(name));
  head.names_line = names_line;
  head.names_in_comment = !plain;
  return head;
}

Status TextHead::fit_names(const std::string& path, std::size_t columns, std::string& passed_by) {
  if (names.empty() || names.size() == columns) return Done{};
  const std::string mismatch =
      "has " + std::to_string(names.size()) + " names for " + std::to_string(columns) + " columns";
  if (!names_in_comment) return Error{path, "line " + std::to_string(names_line), mismatch};
  names.clear();
  passed_by =
      "the comment in line " + std::to_string(names_line) + " " + mismatch + ", and is not taken for them";
  return Done{};
}

bool is_known_width(std::size_t columns) {
  return columns == 3 || columns == 4 || columns == 6 || columns == 7 || columns == 9;
}

Result<Names> infer_text_columns(const std::string& path, const Values& values, std::string& assumed) {
  const std::size_t columns = values.size();
  if (columns == 3) return joined({});
  if (columns == 4) {
    assumed = "column 4 is an intensity";
    return joined({&kIntensity});
  }
  const Triple second = examine(values, 3);
  if (columns == 6) {
    if (ends_in(path, ".xyzrgb")) return joined({&kColor});
    if (ends_in(path, ".xyzn") || second.unit) {
      assumed = "columns 4 to 6 are normals";
      return joined({&kNormal});
    }
    if (second.zero) {
      assumed = "columns 4 to 6 are normals, of which there are none: all are zero";
      return joined({&kNormal});
    }
    if (second.color) {
      assumed = "columns 4 to 6 are colours: as normals they would have length 1";
      return joined({&kColor});
    }
    return Error{path, "columns 4 to 6",
                 std::string("are no unit vectors, and no colours, as some are negative") + kSayIt};
  }
  if (columns == 7) {
    const Triple last = examine(values, 4);
    const bool first_fits = second.byte_color && !ends_in(path, ".pts");
    const bool last_fits = last.byte_color || (ends_in(path, ".pts") && last.color);
    if (first_fits != last_fits) {
      assumed = first_fits ? "columns 4 to 6 are colours, column 7 an intensity"
                           : "column 4 is an intensity, columns 5 to 7 are colours";
      return first_fits ? joined({&kColor, &kIntensity}) : joined({&kIntensity, &kColor});
    }
    return Error{path, "columns 4 to 7",
                 std::string(first_fits ? "could be colours and an intensity in either order"
                                        : "are not colours from 0 to 255 and an intensity") +
                     kSayIt};
  }
  const Triple third = examine(values, 6);
  if (columns == 9 && second.unit != third.unit && (second.unit ? third : second).color) {
    assumed = second.unit ? "columns 4 to 6 are normals, columns 7 to 9 colours"
                          : "columns 4 to 6 are colours, columns 7 to 9 normals";
    return second.unit ? joined({&kNormal, &kColor}) : joined({&kColor, &kNormal});
  }
  return Error{path, "columns 4 to 9", std::string("are not a unit vector and a colour") + kSayIt};
}

bool has_decimal_commas(std::string_view line) {
  bool semicolon = false;
  std::size_t tokens = 0, commas = 0;
  for (const std::string_view token : tokens_of(line, ";")) {
    ++tokens;
    const std::size_t comma = token.find(',');
    if (comma == token.npos) continue;
    const bool between_digits = comma > 0 && comma + 1 < token.size() &&
                                token.find(',', comma + 1) == token.npos && token.find('.') == token.npos &&
                                token[comma - 1] >= '0' && token[comma - 1] <= '9' &&
                                token[comma + 1] >= '0' && token[comma + 1] <= '9';
    if (!between_digits) return false;
    ++commas;
  }
  semicolon = line.find(';') != line.npos;
  return commas > 0 && (semicolon || tokens >= 3);
}

}  // namespace swept
