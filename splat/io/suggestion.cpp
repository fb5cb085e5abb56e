#include "splat/io/suggestion.h"

#include <algorithm>
#include <vector>

namespace swept {
namespace {

/// Edits that turn `a` into `b`: letters put in, left out, replaced, or swapped with the next (optimal string
/// alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({replaced, d[i - 1][j] + 1, d[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string_view nearest_word(std::string_view word, std::span<const std::string_view> known) {
  // A word of a hostile length is not worth the square of it.
  constexpr std::size_t longest = 64;
  if (word.size() > longest || known.empty()) return {};
  // What is the beginning of one word alone was cut short.
  constexpr std::size_t shortest = 4;
  const auto begins = [&](std::string_view other) { return other.starts_with(word); };
  if (word.size() >= shortest && std::count_if(known.begin(), known.end(), begins) == 1)
    return *std::find_if(known.begin(), known.end(), begins);
  const std::string_view nearest =
      *std::min_element(known.begin(), known.end(), [&](std::string_view a, std::string_view b) {
        return edit_distance(word, a) < edit_distance(word, b);
      });
  return edit_distance(word, nearest) * 2 <= nearest.size() ? nearest : std::string_view();
}

std::string suggestion(std::string_view word, std::span<const std::string_view> known) {
  if (const std::string_view nearest = nearest_word(word, known); !nearest.empty())
    return "; did you mean \"" + std::string(nearest) + "\"?";
  std::string list;
  for (const std::string_view key : known) list += (list.empty() ? "\"" : ", \"") + std::string(key) + '"';
  return "; known here: " + list;
}

}  // namespace swept
