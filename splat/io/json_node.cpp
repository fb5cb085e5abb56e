#include "splat/io/json_node.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "splat/io/json_text.h"

namespace swept::io {
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

/// "; did you mean ...?" where one of `known` is near, else the list of them.
std::string suggestion(const std::string& word, std::initializer_list<const char*> known) {
  // A key of a hostile length is not worth the square of it.
  constexpr std::size_t longest = 64;
  if (word.size() <= longest) {
    const auto nearer = [&](const char* a, const char* b) {
      return edit_distance(word, a) < edit_distance(word, b);
    };
    const char* nearest = *std::min_element(known.begin(), known.end(), nearer);
    if (edit_distance(word, nearest) * 2 <= std::strlen(nearest))
      return std::string("; did you mean \"") + nearest + "\"?";
  }
  std::string list;
  for (const char* key : known) list += (list.empty() ? "\"" : ", \"") + std::string(key) + '"';
  return "; known here: " + list;
}

}  // namespace

void JsonNode::fail(const std::string& reason) const { throw Error{*file_, pointer_, reason}; }

void JsonNode::expect(bool right_type, const char* type) const {
  if (!right_type) fail(std::string("expected ") + type + ", found " + value_->type_name());
}

void JsonNode::expect_keys(std::initializer_list<const char*> known) const {
  expect(is_object(), "an object");
  for (const auto& [key, value] : value_->items()) {
    const bool found =
        std::any_of(known.begin(), known.end(), [&, &name = key](const char* word) { return name == word; });
    if (!found)
      JsonNode(value, *file_, join_pointer(pointer_, key)).fail("unknown key" + suggestion(key, known));
  }
}

std::optional<JsonNode> JsonNode::find(const std::string& key) const {
  expect(is_object(), "an object");
  const auto found = value_->find(key);
  if (found == value_->end()) return std::nullopt;
  return JsonNode(*found, *file_, join_pointer(pointer_, key));
}

JsonNode JsonNode::require(const std::string& key) const {
  const std::optional<JsonNode> found = find(key);
  if (!found) fail("the key \"" + key + "\" is missing");
  return *found;
}

std::vector<std::string> JsonNode::keys() const {
  expect(is_object(), "an object");
  std::vector<std::string> names;
  for (const auto& [key, value] : value_->items()) names.push_back(key);
  return names;
}

std::vector<JsonNode> JsonNode::elements() const {
  expect(is_array(), "an array");
  std::vector<JsonNode> nodes;
  for (std::size_t i = 0; i < value_->size(); ++i)
    nodes.push_back(JsonNode((*value_)[i], *file_, join_pointer(pointer_, std::to_string(i))));
  return nodes;
}

double JsonNode::number() const {
  expect(value_->is_number(), "a number");
  return value_->get<double>();
}

double JsonNode::positive() const {
  const double value = number();
  if (!(value > 0.0)) fail("must be above 0");
  return value;
}

long long JsonNode::integer(long long low, long long high) const {
  const double value = number();
  if (value != std::floor(value)) fail("expected a whole number");
  // Bounds are small enough for double to hold exactly, and a value within them converts exactly.
  if (value < static_cast<double>(low) || value > static_cast<double>(high))
    fail("must be between " + std::to_string(low) + " and " + std::to_string(high));
  return static_cast<long long>(value);
}

bool JsonNode::boolean() const {
  expect(value_->is_boolean(), "true or false");
  return value_->get<bool>();
}

const std::string& JsonNode::string() const {
  expect(value_->is_string(), "a string");
  return value_->get_ref<const std::string&>();
}

std::size_t JsonNode::one_of(std::initializer_list<const char*> words) const {
  const std::string& word = string();
  const auto found =
      std::find_if(words.begin(), words.end(), [&](const char* known) { return word == known; });
  if (found == words.end()) fail('"' + word + "\" is not known" + suggestion(word, words));
  return static_cast<std::size_t>(found - words.begin());
}

std::vector<double> JsonNode::numbers(std::size_t count) const {
  expect(is_array(), "an array");
  if (value_->size() != count)
    fail("expected " + std::to_string(count) + " numbers, found " + std::to_string(value_->size()));
  std::vector<double> values;
  for (const JsonNode& element : elements()) values.push_back(element.number());
  return values;
}

Eigen::Vector3d JsonNode::vector3() const {
  const std::vector<double> values = numbers(3);
  return {values[0], values[1], values[2]};
}

}  // namespace swept::io
