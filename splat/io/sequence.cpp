#include "splat/io/sequence.h"
#include "splat/io/guarded.h"

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

/// Where a placeholder ends, and how many digits it asks for, which may be more or fewer than there can be.
struct Placeholder {
  std::size_t end = 0;
  int digits = 1;
};

/// The one that begins at `begin`, if any does.
std::optional<Placeholder> placeholder_at(const std::string& text, std::size_t begin) {
  const char* const last = text.data() + text.size();
  const char* at = text.data() + begin + 1;
  Placeholder found;
  const auto end_at = [&](const char* end) {
    found.end = static_cast<std::size_t>(end - text.data());
    return found;
  };
  if (text[begin] == '#') {
    found.end = std::min(text.find_first_not_of('#', begin), text.size());
    found.digits = static_cast<int>(std::min<std::size_t>(found.end - begin, kMostDigits + 1));
    return found;
  }
  if (text[begin] == '%') {
    // Only %d and %0Nd: widths filled with blanks make no file names.
    if (at != last && *at == '0') {
      const auto [stop, code] = std::from_chars(at + 1, last, found.digits);
      if (code != std::errc{}) return std::nullopt;
      at = stop;
    }
    if (at == last || *at != 'd') return std::nullopt;
    return end_at(at + 1);
  }
  // $F and $F4; $FF is Houdini's fraction of a frame.
  if (text[begin] != '$' || at == last || *at != 'F') return std::nullopt;
  ++at;
  if (at != last && *at == 'F') return std::nullopt;
  if (at != last && *at >= '0' && *at <= '9') {
    const auto [stop, code] = std::from_chars(at, last, found.digits);
    if (code != std::errc{}) return std::nullopt;
    at = stop;
  }
  return end_at(at);
}

/// Only in the file's own name: what a folder's says is no pattern, nor is a % that no number follows.
Result<Pattern> parse_pattern(const std::string& text) {
  const std::size_t name = text.rfind('/') + 1;  // npos + 1 is 0
  std::optional<Pattern> pattern;
  for (std::size_t i = name; i < text.size(); ++i) {
    const std::optional<Placeholder> found = placeholder_at(text, i);
    if (!found) continue;
    if (pattern) return Error{text, "pattern", "has more than one placeholder", ErrorKind::argument};
    pattern = Pattern{text.substr(0, i), text.substr(found->end), found->digits};
    i = found->end - 1;
  }
  if (!pattern)
    return Error{text, "pattern", "needs one placeholder for the number, such as ####, %04d or $F4",
                 ErrorKind::argument};
  if (pattern->digits < 1 || pattern->digits > kMostDigits)
    return Error{text, "pattern", "asks for fewer than 1 or more than 32 digits", ErrorKind::argument};
  return *pattern;
}

/// `width` digits at least, and a minus sign before them where there is one.
std::string fill(const Pattern& pattern, int number, int width) {
  const bool negative = number < 0;
  std::string digits = std::to_string(number).substr(negative ? 1 : 0);
  if (const auto wanted = static_cast<std::size_t>(width); digits.size() < wanted)
    digits.insert(0, wanted - digits.size(), '0');
  return pattern.before + (negative ? "-" : "") + digits + pattern.after;
}

/// As printf has it, where the sign takes the place of a digit.
std::string fill(const Pattern& pattern, int number) {
  return fill(pattern, number, pattern.digits - (number < 0 ? 1 : 0));
}

/// As others have it.
std::string fill_beside_sign(const Pattern& pattern, int number) {
  return fill(pattern, number, pattern.digits);
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
  return io::guarded(pattern, [&]() -> Result<std::vector<NumberedFile>> {
    const Result<Pattern> parsed = parse_pattern(pattern);
    if (!parsed) return parsed.error();
    const std::size_t slash = parsed->before.find_last_of('/');
    const std::string folder = slash == std::string::npos ? "" : parsed->before.substr(0, slash + 1);
    const std::string before = parsed->before.substr(folder.size());

    std::vector<NumberedFile> files;
    std::error_code code;
    std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, code);
    if (code) return Error{pattern, "", "its folder cannot be read", ErrorKind::not_found};
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
      if (!number || !middle.empty()) continue;
      const std::string path = folder + name;
      if (fill(*parsed, *number) != path && fill_beside_sign(*parsed, *number) != path) continue;
      files.push_back({*number, path});
    }
    if (code) return Error{pattern, "", "its folder cannot be read", ErrorKind::not_found};
    if (files.empty()) return Error{pattern, "", "no such file", ErrorKind::not_found};
    std::sort(files.begin(), files.end(),
              [](const NumberedFile& a, const NumberedFile& b) { return a.number < b.number; });
    const auto same = std::adjacent_find(files.begin(), files.end(),
                                         [](const auto& a, const auto& b) { return a.number == b.number; });
    if (same != files.end())
      return Error{pattern, "",
                   "both " + same->path + " and " + (same + 1)->path + " are its file " +
                       std::to_string(same->number)};
    return files;
  });
}

bool is_sequence_pattern(const std::string& path) {
  for (std::size_t i = path.rfind('/') + 1; i < path.size(); ++i)
    if (placeholder_at(path, i)) return true;
  return false;
}

Result<std::string> find_in_sequence(const std::string& pattern, int number) {
  const Result<Pattern> parsed = parse_pattern(pattern);
  if (!parsed) return parsed.error();
  std::string path = fill(*parsed, number);
  if (number >= 0) return path;
  std::error_code code;
  std::string other = fill_beside_sign(*parsed, number);
  return std::filesystem::exists(path, code) || !std::filesystem::exists(other, code) ? path : other;
}

std::string frame_ranges_text(const std::vector<int>& frames) {
  std::string text;
  const auto gap = [&](std::size_t i) { return static_cast<long long>(frames[i]) - frames[i - 1]; };
  for (std::size_t begin = 0, end = 0; begin < frames.size(); begin = end) {
    end = begin + 1;
    const long long step = end < frames.size() ? gap(end) : 1;
    while (end < frames.size() && gap(end) == step) ++end;
    if (end - begin == 2 && step != 1) end = begin + 1;
    if (!text.empty()) text += ',';
    text += std::to_string(frames[begin]);
    if (end - begin == 1) continue;
    text += '-' + std::to_string(frames[end - 1]);
    if (step != 1) text += 'x' + std::to_string(step);
  }
  return text;
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
