#include "splat/io/json_text.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace swept::io {
namespace {

using nlohmann::json;

/// Line and column, from 1, of the last byte read.
std::string place(std::string_view text, std::size_t bytes_read) {
  const std::string_view before = text.substr(0, bytes_read > 0 ? bytes_read - 1 : 0);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return "line " + std::to_string(line) + ", column " + std::to_string(before.size() - line_begin + 1);
}

/// The parser's own sentence, without its prefix "[json.exception...] parse error at ...: ".
std::string plain_reason(const std::string& what) {
  constexpr std::string_view marker = ": ";
  const std::size_t at = what.find(marker);
  return at == std::string::npos ? what : what.substr(at + marker.size());
}

/// Reads the text once for its errors; the document itself is built by the library's own parser.
class Checker : public json::json_sax_t {
 public:
  Checker(const std::string& file, const std::string& text) : file_(file), text_(text) {}

  const Error& error() const { return error_; }

  /// Of a document without bad syntax: whether it is too large to be kept.
  Status size() const {
    if (deepest_ > most_levels)
      return Error{file_, too_deep_at_, "nested in more than " + std::to_string(most_levels) + " levels"};
    if (values_ > most_values)
      return Error{file_, "", "holds more than " + std::to_string(most_values) + " values"};
    return Done{};
  }

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }

  bool start_object(std::size_t) override { return open(false); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(true); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    if (depth_ > most_levels || values_ > most_values) return true;
    levels_.back().token = name;
    if (levels_.back().keys.insert(name).second) return true;
    error_ = {file_, pointer(), "the key appears twice in one object"};
    return false;
  }

  bool parse_error(std::size_t position, const std::string&, const json::exception& exception) override {
    constexpr int number_overflow = 406;
    const bool too_large = exception.id == number_overflow;
    error_ = {file_, place(text_, position),
              too_large ? "the number is too large for a double" : plain_reason(exception.what())};
    return false;
  }

 private:
  struct Level {
    bool is_array = false;
    std::size_t next_index = 0;
    std::string token;
    std::set<std::string> keys;
  };

  // A scene has seven levels, and 100,000 camera keys of matrices have two million values. What is beyond is
  // read on for its syntax, but not kept.
  static constexpr std::size_t most_levels = 64, most_values = 4'000'000;

  std::string pointer() const {
    std::string pointer;
    for (const Level& level : levels_)
      pointer = join_pointer(pointer, level.is_array ? std::to_string(level.next_index) : level.token);
    return pointer;
  }

  bool value() {
    ++values_;
    if (depth_ <= most_levels && !levels_.empty()) ++levels_.back().next_index;
    return true;
  }

  bool open(bool is_array) {
    ++depth_;
    if (depth_ == most_levels + 1 && deepest_ < depth_) too_deep_at_ = pointer();
    deepest_ = std::max(deepest_, depth_);
    if (depth_ > most_levels) return true;
    levels_.push_back({});
    levels_.back().is_array = is_array;
    return true;
  }

  bool close() {
    if (depth_-- <= most_levels) levels_.pop_back();
    return value();
  }

  const std::string& file_;
  const std::string& text_;
  std::vector<Level> levels_;
  std::size_t depth_ = 0, deepest_ = 0, values_ = 0;
  std::string too_deep_at_;
  Error error_;
};

}  // namespace

std::string join_pointer(const std::string& pointer, const std::string& key) {
  std::string joined = pointer + '/';
  for (const char c : key) {
    if (c == '~')
      joined += "~0";
    else if (c == '/')
      joined += "~1";
    else
      joined += c;
  }
  return joined;
}

Result<nlohmann::json> parse_json(const std::string& file, const std::string& text) {
  Checker checker(file, text);
  if (!json::sax_parse(text, &checker)) return checker.error();
  if (const Status size = checker.size(); !size) return size.error();
  try {
    return json::parse(text);
  } catch (const json::exception& exception) {
    return Error{file, "", exception.what()};
  }
}

}  // namespace swept::io
