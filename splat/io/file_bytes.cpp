#include "splat/io/file_bytes.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>

namespace swept {
namespace {

std::uintmax_t memory_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return std::numeric_limits<std::uintmax_t>::max();
  return static_cast<std::uintmax_t>(pages) * static_cast<std::uintmax_t>(page_bytes);
}

/// The power of ten of the first digit that is not zero, of a number that is well-formed and not zero. Held
/// to what two exponents and a long file could add up to.
long long decimal_magnitude(std::string_view number) {
  constexpr long long most = 1'000'000'000'000'000;
  const std::size_t e = std::min(number.find_first_of("eE"), number.size());
  long long exponent = 0;
  if (e < number.size()) {
    std::string_view digits = number.substr(e + 1);
    if (digits.front() == '+') digits.remove_prefix(1);
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
    if (code != std::errc{}) exponent = digits.front() == '-' ? -most : most;
    exponent = std::clamp(exponent, -most, most);
  }
  const std::string_view mantissa = number.substr(0, e);
  const std::size_t first = mantissa.find_first_of("123456789");
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  if (first == mantissa.npos) return 0;
  const auto places = static_cast<long long>(point) - static_cast<long long>(first);
  return exponent + (places > 0 ? places - 1 : places);
}

}  // namespace

Result<std::string> read_bytes(const std::string& path) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) return Error{path, "", "no such file", ErrorKind::not_found};
  // A pipe or a device could go on for ever.
  if (!std::filesystem::is_regular_file(status)) return Error{path, "", "is not a regular file"};
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  std::ifstream file(path, std::ios::binary);
  if (code || !file) return Error{path, "", "cannot be opened for reading", ErrorKind::not_found};
  // A sparse file may claim any size, and what is asked for beyond the memory there is ends the process.
  if (size > memory_bytes())
    return Error{path, "", "is larger than the memory of this machine", ErrorKind::out_of_memory};
  try {
    std::string bytes(static_cast<std::size_t>(size), '\0');
    file.read(bytes.data(), static_cast<std::streamsize>(size));
    if (static_cast<std::uintmax_t>(file.gcount()) != size)
      return Error{path, "", "cannot be read to its end", ErrorKind::device};
    return bytes;
  } catch (const std::bad_alloc&) {
    return Error{path, "", "does not fit into memory", ErrorKind::out_of_memory};
  }
}

std::optional<double> parse_number(std::string_view token) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (token.empty() || end != token.data() + token.size()) return std::nullopt;
  if (code == std::errc::result_out_of_range) {
    const double sign = token.front() == '-' ? -1.0 : 1.0;
    return sign * (decimal_magnitude(token) > 0 ? std::numeric_limits<double>::infinity() : 0.0);
  }
  if (code != std::errc{}) return std::nullopt;
  return value;
}

LineScanner::LineScanner(std::string_view text, std::string_view separators, char continuation)
    : text_(text), blanks_(" \t\r\v\f"), continuation_(continuation) {
  blanks_ += separators;
}

void LineScanner::take_line() {
  const std::size_t length = std::min(text_.find('\n'), text_.size());
  line_ = text_.substr(0, length);
  text_.remove_prefix(std::min(length + 1, text_.size()));
  ++line_number_;
  line_ = line_.substr(0, line_.find('#'));
  continues_ = false;
  if (continuation_ == '\0') return;
  const std::size_t last = line_.find_last_not_of('\r');
  continues_ = last != line_.npos && line_[last] == continuation_;
  if (continues_) line_ = line_.substr(0, last);
}

bool LineScanner::next_line() {
  while (continues_ && !text_.empty()) take_line();  // what nobody asked for
  while (!text_.empty()) {
    take_line();
    while (continues_ && line_.find_first_not_of(blanks_) == line_.npos && !text_.empty()) take_line();
    if (line_.find_first_not_of(blanks_) != line_.npos) return true;
  }
  return false;
}

std::string_view LineScanner::next_token() {
  line_.remove_prefix(std::min(line_.find_first_not_of(blanks_), line_.size()));
  while (line_.empty() && continues_ && !text_.empty()) {
    take_line();
    line_.remove_prefix(std::min(line_.find_first_not_of(blanks_), line_.size()));
  }
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
