// The fields of the table, from JSON and to it.
#include <algorithm>

#include "splat/io/json_text.h"
#include "splat/io/scene_parsing.h"

namespace swept {
namespace io {
namespace {

/// A list, or where one number is enough, that number.
std::vector<double> list_of(const Field& field, const JsonNode& node) {
  if (field.least == 1 && node.is_number()) return {node.number()};
  const std::size_t least = std::max<std::size_t>(field.least, 2), most = field.numbers.size();
  const std::vector<JsonNode> elements = node.elements();
  if (elements.size() < least || elements.size() > most) {
    const std::string either =
        least < most ? std::to_string(least) + (most - least > 1 ? " to " : " or ") : "";
    node.fail("expected " + either + std::to_string(most) + " numbers, found " +
              std::to_string(elements.size()));
  }
  std::vector<double> values;
  for (const JsonNode& element : elements) values.push_back(element.number());
  return values;
}

std::vector<double> values_of(const Field& field, const JsonNode& node) {
  if (!field.words.empty()) return {static_cast<double>(node.one_of(field.words))};
  std::vector<double> values = field.numbers.size() > 1 ? list_of(field, node) : std::vector{node.number()};
  if (const Status legal = field.legal(values); !legal)
    throw Error{node.file(), legal.error().field, legal.error().reason, in_a_file(legal.error().kind)};
  return values;
}

nlohmann::ordered_json json_of(const FieldNumber& number, double value) {
  if (number.whole) return static_cast<long long>(value);
  return value;
}

nlohmann::ordered_json json_of(const Field& field, const std::vector<double>& values) {
  if (!field.words.empty()) return field.words[static_cast<std::size_t>(values[0])];
  if (values.size() == 1) return json_of(field.numbers[0], values[0]);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < values.size(); ++i) list.push_back(json_of(field.numbers[i], values[i]));
  return list;
}

}  // namespace

std::vector<std::string_view> root_field_names() {
  std::vector<std::string_view> names;
  for (const Field& field : scene_fields()) {
    const std::string_view name = field.group().empty() ? field.name() : field.group();
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

void parse_fields(const JsonNode& root, Scene& scene) {
  std::map<std::string_view, std::vector<std::string_view>> groups;
  for (const Field& field : scene_fields())
    if (!field.group().empty()) groups[field.group()].push_back(field.name());
  for (const auto& [group, names] : groups)
    if (const auto node = root.find(std::string(group))) node->expect_keys(names);

  for (const Field& field : scene_fields()) {
    const auto parent = field.group().empty() ? root : root.find(std::string(field.group()));
    if (!parent) continue;
    const std::string name(field.name());
    const auto node = field.with_object ? parent->require(name) : parent->find(name);
    if (node) field.set(scene, values_of(field, *node));
  }
}

}  // namespace io

std::string fields_to_text(const Scene& scene) {
  nlohmann::ordered_json root = nlohmann::ordered_json::object();
  for (const Field& field : scene_fields()) {
    const std::vector<double> values = field.get(scene);
    if (field.unset(values)) continue;
    nlohmann::ordered_json& parent = field.group().empty() ? root : root[std::string(field.group())];
    parent[std::string(field.name())] = io::json_of(field, values);
  }
  return root.dump(2) + '\n';
}

}  // namespace swept
