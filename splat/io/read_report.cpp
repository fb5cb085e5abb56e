#include "splat/io/read_report.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace swept {
namespace {

constexpr std::size_t kMostListed = 24;
constexpr std::size_t kMostShown = 40;

std::string shortened(std::string_view name) {
  std::string shown(name.substr(0, kMostShown));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  if (name.size() > kMostShown) shown += "...";
  return shown;
}

struct Numbered {
  std::string_view stem;
  long long number = 0;
};

std::optional<Numbered> numbered(std::string_view name) {
  const std::size_t stem = name.find_last_not_of("0123456789") + 1;
  if (stem == 0 || stem == name.size()) return std::nullopt;
  Numbered parts{name.substr(0, stem), 0};
  const auto [end, code] = std::from_chars(name.data() + stem, name.data() + name.size(), parts.number);
  if (code != std::errc{}) return std::nullopt;
  return parts;
}

/// How many names from `begin` on count up by one from the first.
std::size_t run_length(const std::vector<std::string>& names, std::size_t begin) {
  const auto first = numbered(names[begin]);
  std::size_t length = 1;
  while (first && begin + length < names.size()) {
    const auto next = numbered(names[begin + length]);
    if (!next || next->stem != first->stem || next->number != first->number + static_cast<long long>(length))
      break;
    ++length;
  }
  return length;
}

}  // namespace

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  std::size_t shown = 0;
  for (std::size_t i = 0; i < names.size();) {
    if (shown++ == kMostListed) return text + " and " + std::to_string(names.size() - i) + " more";
    if (!text.empty()) text += ", ";
    text += shortened(names[i]);
    const std::size_t run = run_length(names, i);
    if (run >= 3) text += " to " + shortened(names[i + run - 1]);
    i += run >= 3 ? run : 1;
  }
  return text;
}

std::vector<std::string> ReadReport::properties_of(const std::string& attribute) const {
  const auto use =
      std::find_if(used.begin(), used.end(), [&](const Use& u) { return u.attribute == attribute; });
  return use == used.end() ? std::vector<std::string>{} : use->properties;
}

std::vector<std::string> ReadReport::lines() const {
  std::vector<std::string> lines;
  std::string read;
  for (const Use& use : used) {
    if (!read.empty()) read += "; ";
    read += use.attribute + " from " + listed(use.properties);
  }
  if (!read.empty()) lines.push_back("read: " + read);
  if (!unread.empty()) lines.push_back("unread: " + listed(unread));
  for (const std::string& assumption : assumed) lines.push_back("assumed: " + assumption);
  return lines;
}

}  // namespace swept
