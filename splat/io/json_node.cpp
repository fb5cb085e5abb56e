#include "splat/io/json_node.h"

#include <algorithm>
#include <cmath>

#include "splat/io/json_text.h"
#include "splat/io/suggestion.h"

namespace swept::io {
void JsonNode::fail(const std::string& reason) const { throw Error{*file_, pointer_, reason}; }

void JsonNode::expect(bool right_type, const char* type) const {
  if (!right_type) fail(std::string("expected ") + type + ", found " + value_->type_name());
}

void JsonNode::expect_keys(std::span<const std::string_view> known) const {
  expect(is_object(), "an object");
  for (const auto& [key, value] : value_->items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
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

JsonNode JsonNode::at(std::size_t index) const {
  return {(*value_)[index], *file_, join_pointer(pointer_, std::to_string(index))};
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

std::size_t JsonNode::one_of(std::span<const std::string_view> words) const {
  const std::string& word = string();
  const auto found = std::find(words.begin(), words.end(), word);
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
