#include "splat/io/sequence.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <unordered_set>

namespace swept {
namespace {

constexpr int kMostDigits = 32;
constexpr std::size_t kMostFrames = 1'000'000;

/// The text around the number of a pattern, and how many digits it is filled up to.
struct Pattern {
  std::string before, after;
  int digits = 1;
};

Result<Pattern> parse_pattern(const std::string& text) {
  const Error none{text, "pattern", "needs one placeholder for the number, such as #### or %04d"};
  const std::size_t begin = text.find_first_of("#%");
  if (begin == text.npos) return none;
  Pattern pattern;
  pattern.before = text.substr(0, begin);
  std::size_t end = begin;
  if (text[begin] == '#') {
    end = std::min(text.find_first_not_of('#', begin), text.size());
    pattern.digits = static_cast<int>(std::min<std::size_t>(end - begin, kMostDigits + 1));
  } else {
    const char* const last = text.data() + text.size();
    const char* at = text.data() + begin + 1;
    // Only %d and %0Nd: widths filled with blanks make no file names.
    if (at != last && *at == '0') {
      const auto [stop, code] = std::from_chars(at + 1, last, pattern.digits);
      if (code != std::errc{}) return none;
      at = stop;
    }
    if (at == last || *at != 'd') return none;
    end = static_cast<std::size_t>(at + 1 - text.data());
  }
  if (pattern.digits < 1 || pattern.digits > kMostDigits) {
    return Error{text, "pattern", "asks for fewer than 1 or more than 32 digits"};
  }
  pattern.after = text.substr(end);
  if (pattern.after.find_first_of("#%") != std::string::npos) {
    return Error{text, "pattern", "has more than one placeholder"};
  }
  return pattern;
}

std::string fill(const Pattern& pattern, int number) {
  const bool negative = number < 0;
  std::string digits = std::to_string(number).substr(negative ? 1 : 0);
  // As printf has it, the sign takes the place of a digit.
  const auto width = static_cast<std::size_t>(pattern.digits - (negative ? 1 : 0));
  if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
  return pattern.before + (negative ? "-" : "") + digits + pattern.after;
}

/// Takes a whole number off the front of `text`.
std::optional<int> take_number(std::string_view& text) {
  int value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

struct Range {
  int first = 0, last = 0, step = 1;
};

std::optional<Range> parse_range(std::string_view text) {
  Range range;
  const auto first = take_number(text);
  if (!first) return std::nullopt;
  range.first = range.last = *first;
  if (take(text, '-')) {
    const auto last = take_number(text);
    if (!last) return std::nullopt;
    range.last = *last;
    if (take(text, 'x')) {
      const auto step = take_number(text);
      if (!step || *step < 1) return std::nullopt;
      range.step = *step;
    }
  }
  if (!text.empty()) return std::nullopt;
  return range;
}

}  // namespace

Result<std::string> sequence_path(const std::string& pattern, int number) {
  const Result<Pattern> parsed = parse_pattern(pattern);
  if (!parsed) return parsed.error();
  return fill(*parsed, number);
}

Result<std::vector<NumberedFile>> list_sequence(const std::string& pattern) {
  const Result<Pattern> parsed = parse_pattern(pattern);
  if (!parsed) return parsed.error();
  const std::size_t slash = parsed->before.find_last_of('/');
  if (parsed->after.find('/') != std::string::npos) {
    return Error{pattern, "pattern", "must have its placeholder in the name of the file, not of a folder"};
  }
  const std::string folder = slash == std::string::npos ? "" : parsed->before.substr(0, slash + 1);
  const std::string before = parsed->before.substr(folder.size());

  std::vector<NumberedFile> files;
  std::error_code code;
  std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, code);
  if (code) return Error{pattern, "", "its folder cannot be read"};
  for (; entry != std::filesystem::directory_iterator(); entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    if (name.size() <= before.size() + parsed->after.size() || name.compare(0, before.size(), before) != 0)
      continue;
    std::string_view middle(name);
    middle.remove_prefix(before.size());
    if (middle.substr(middle.size() - parsed->after.size()) != parsed->after) continue;
    middle.remove_suffix(parsed->after.size());
    const auto number = take_number(middle);
    // Only names that the pattern itself would give: 7 and 0007 are not the same file.
    if (!number || !middle.empty() || fill(*parsed, *number) != folder + name) continue;
    files.push_back({*number, folder + name});
  }
  if (code) return Error{pattern, "", "its folder cannot be read"};
  if (files.empty()) return Error{pattern, "", "no such file"};
  std::sort(files.begin(), files.end(),
            [](const NumberedFile& a, const NumberedFile& b) { return a.number < b.number; });
  return files;
}

Result<std::vector<int>> parse_frame_ranges(std::string_view text) {
  std::string quoted = "'";
  quoted.append(text) += "'";
  const Error malformed{"", "frames", quoted + " is not a list of frames such as 1-100x2,120"};
  std::vector<int> frames;
  std::unordered_set<int> seen;
  while (true) {
    const std::size_t comma = std::min(text.find(','), text.size());
    const std::optional<Range> range = parse_range(text.substr(0, comma));
    if (!range) return malformed;
    if (range->last < range->first) {
      return Error{"", "frames",
                   "the range from " + std::to_string(range->first) + " to " + std::to_string(range->last) +
                       " runs backwards"};
    }
    for (long long f = range->first; f <= range->last; f += range->step) {
      if (!seen.insert(static_cast<int>(f)).second) continue;
      frames.push_back(static_cast<int>(f));
      if (frames.size() > kMostFrames) return Error{"", "frames", "names more than a million frames"};
    }
    if (comma == text.size()) return frames;
    text.remove_prefix(comma + 1);
  }
}

}  // namespace swept
