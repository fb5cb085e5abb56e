#include "splat/io/file_bytes.h"

#include <algorithm>
#include <charconv>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>

namespace swept {

Result<std::string> read_bytes(const std::string& path) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) return Error{path, "", "no such file"};
  // A pipe or a device could go on for ever.
  if (!std::filesystem::is_regular_file(status)) return Error{path, "", "is not a regular file"};
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  std::ifstream file(path, std::ios::binary);
  if (code || !file) return Error{path, "", "cannot be opened for reading"};
  std::string bytes;
  try {
    bytes.resize(static_cast<std::size_t>(size));
  } catch (const std::exception&) {
    return Error{path, "", "does not fit into memory"};
  }
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(file.gcount()) != size) return Error{path, "", "cannot be read to its end"};
  return bytes;
}

namespace {

/// The decimal exponent of the first digit that is not 0, of a number that std::from_chars() has read to its
/// end. That of 0.0012e5 is 2.
long long magnitude_of(std::string_view token) {
  const std::size_t exponent_at = std::min(token.find_first_of("eE"), token.size());
  const std::string_view digits = token.substr(0, exponent_at);
  const auto point = static_cast<long long>(std::min(digits.find('.'), digits.size()));
  const std::size_t first_at = digits.find_first_of("123456789");
  const auto first = static_cast<long long>(first_at == digits.npos ? 0 : first_at);
  const long long shift = first < point ? point - first - 1 : point - first;
  if (exponent_at == token.size()) return shift;
  std::string_view text = token.substr(exponent_at + 1);
  const bool negative = text.starts_with('-');
  if (text.starts_with('+') || negative) text.remove_prefix(1);
  long long exponent = 0;
  // Beyond every file's length in digits, where it does not fit.
  if (std::from_chars(text.data(), text.data() + text.size(), exponent).ec != std::errc{})
    exponent = std::numeric_limits<long long>::max() / 2;
  return shift + (negative ? -exponent : exponent);
}

}  // namespace

std::optional<double> parse_number(std::string_view token) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (token.empty() || end != token.data() + token.size()) return std::nullopt;
  if (code == std::errc::result_out_of_range) {
    const double beyond = magnitude_of(token) < 0 ? 0.0 : std::numeric_limits<double>::infinity();
    return token.front() == '-' ? -beyond : beyond;
  }
  if (code != std::errc{}) return std::nullopt;
  return value;
}

LineScanner::LineScanner(std::string_view text, std::string_view separators)
    : text_(text), blanks_(" \t\r\v\f") {
  blanks_ += separators;
}

bool LineScanner::next_line() {
  while (!text_.empty()) {
    const std::size_t length = std::min(text_.find('\n'), text_.size());
    line_ = text_.substr(0, length);
    text_.remove_prefix(std::min(length + 1, text_.size()));
    ++line_number_;
    line_ = line_.substr(0, line_.find('#'));
    if (line_.find_first_not_of(blanks_) != line_.npos) return true;
  }
  return false;
}

std::string_view LineScanner::next_token() {
  line_.remove_prefix(std::min(line_.find_first_not_of(blanks_), line_.size()));
  const std::string_view token = line_.substr(0, line_.find_first_of(blanks_));
  line_.remove_prefix(token.size());
  return token;
}

std::string not_a_number(std::string_view token) {
  constexpr std::size_t kShown = 24;
  std::string shown(token.substr(0, kShown));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  if (token.size() > kShown) shown += "...";
  return "'" + shown + "' is not a number";
}

}  // namespace swept
