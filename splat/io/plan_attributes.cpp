#include <algorithm>
#include <array>
#include <string_view>

#include "splat/io/attributes.h"

namespace swept {
namespace {

using Names = std::vector<std::string>;

/// An attribute and the names it goes by where the caller gives none.
struct Attribute {
  const char* name;
  std::size_t least, most;  ///< how many columns
  std::vector<Names> usual;
};

std::vector<Attribute> known_attributes() {
  return {{"position", 3, 3, {{"x", "y", "z"}}},
          {"normal", 3, 3, {{"nx", "ny", "nz"}, {"normal_x", "normal_y", "normal_z"}}},
          {"velocity",
           3,
           3,
           {{"vx", "vy", "vz"},
            {"velocity_x", "velocity_y", "velocity_z"},
            {"velocities_x", "velocities_y", "velocities_z"}}},
          {"color",
           3,
           4,
           {{"red", "green", "blue", "alpha"},
            {"red", "green", "blue"},
            {"r", "g", "b", "a"},
            {"r", "g", "b"},
            {"diffuse_red", "diffuse_green", "diffuse_blue"}}},
          {"radius", 1, 1, {{"radius"}}},
          {"width", 1, 1, {{"width"}}},
          {"opacity", 1, 1, {{"opacity"}}}};
}

std::optional<std::size_t> find_column(const std::vector<Column>& columns, const std::string& name) {
  const auto it =
      std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return c.name == name; });
  if (it == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(it - columns.begin());
}

/// All of the names, or nothing.
std::vector<std::size_t> find_columns(const std::vector<Column>& columns, const Names& names) {
  std::vector<std::size_t> found;
  for (const std::string& name : names) {
    const auto column = find_column(columns, name);
    if (!column) return {};
    found.push_back(*column);
  }
  return found;
}

Names split_names(const std::string& list) {
  Names names;
  std::size_t begin = 0;
  while (begin <= list.size()) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    std::string name = list.substr(begin, end - begin);
    name.erase(0, std::min(name.find_first_not_of(' '), name.size()));
    name.erase(name.find_last_not_of(' ') + 1);
    names.push_back(name);
    begin = end + 1;
  }
  return names;
}

/// Columns the caller asks for by name.
Result<std::vector<std::size_t>> mapped_columns(const std::string& path, const std::vector<Column>& columns,
                                                const Attribute& attribute, const std::string& list) {
  if (list.empty()) return std::vector<std::size_t>{};
  const Names names = split_names(list);
  const std::string field = std::string("attributes.") + attribute.name;
  if (names.size() < attribute.least || names.size() > attribute.most) {
    return Error{path, field,
                 "names " + std::to_string(names.size()) + " properties, must name " +
                     std::to_string(attribute.least)};
  }
  std::vector<std::size_t> found;
  for (const std::string& name : names) {
    const auto column = find_column(columns, name);
    if (!column) return Error{path, field, "the file has no property '" + name + "'"};
    found.push_back(*column);
  }
  return found;
}

std::optional<AttributePlan::Triple> triple(const std::vector<std::size_t>& found) {
  if (found.size() < 3) return std::nullopt;
  return AttributePlan::Triple{found[0], found[1], found[2]};
}

void plan_gaussians(const std::vector<Column>& columns, AttributePlan& plan) {
  std::vector<std::size_t> scales = find_columns(columns, {"scale_0", "scale_1", "scale_2"});
  if (scales.empty()) scales = find_columns(columns, {"scale_0", "scale_1"});
  const std::vector<std::size_t> q = find_columns(columns, {"rot_0", "rot_1", "rot_2", "rot_3"});
  if (scales.empty() || q.empty()) return;
  plan.log_scale = scales;
  std::copy(q.begin(), q.end(), plan.quaternion.begin());
  if (!plan.color) plan.harmonic = triple(find_columns(columns, {"f_dc_0", "f_dc_1", "f_dc_2"}));
  plan.normal.reset();  // trainers write zeros there; the disc's own normal is the one that counts
}

}  // namespace

std::vector<bool> AttributePlan::needed(std::size_t count) const {
  std::vector<bool> is_needed(count, false);
  const auto mark = [&](const auto& some) {
    for (const std::size_t c : some) is_needed[c] = true;
  };
  mark(position);
  for (const auto& vector : {normal, velocity, color, harmonic}) {
    if (vector) mark(*vector);
  }
  for (const auto& scalar : {radius, opacity, alpha}) {
    if (scalar) is_needed[*scalar] = true;
  }
  mark(log_scale);
  if (!log_scale.empty()) mark(quaternion);
  return is_needed;
}

Result<AttributePlan> plan_attributes(const std::string& path, const std::vector<Column>& columns,
                                      const ReadOptions& options) {
  const std::vector<Attribute> attributes = known_attributes();
  for (const auto& [name, list] : options.attributes) {
    if (std::none_of(attributes.begin(), attributes.end(),
                     [&name = name](const Attribute& a) { return a.name == name; })) {
      return Error{
          path, "attributes." + name,
          "is not an attribute; known are position, normal, velocity, color, radius, width, opacity"};
    }
  }
  std::map<std::string_view, std::vector<std::size_t>> found;
  for (const Attribute& attribute : attributes) {
    if (const auto mapped = options.attributes.find(attribute.name); mapped != options.attributes.end()) {
      auto chosen = mapped_columns(path, columns, attribute, mapped->second);
      if (!chosen) return chosen.error();
      found[attribute.name] = *chosen;
      continue;
    }
    for (const Names& names : attribute.usual) {
      if (found[attribute.name] = find_columns(columns, names); !found[attribute.name].empty()) break;
    }
  }
  AttributePlan plan;
  if (const auto position = triple(found["position"])) {
    plan.position = *position;
  } else {
    for (const char* name : {"x", "y", "z"}) {
      if (!find_column(columns, name))
        return Error{path, name, "the file has no such property: no positions"};
    }
    return Error{path, "attributes.position", "names no properties: no positions"};
  }
  plan.normal = triple(found["normal"]);
  plan.velocity = triple(found["velocity"]);
  plan.color = triple(found["color"]);
  if (found["color"].size() == 4) plan.alpha = found["color"][3];
  if (!found["opacity"].empty()) plan.opacity = found["opacity"][0];
  if (!found["radius"].empty()) {
    plan.radius = found["radius"][0];
  } else if (!found["width"].empty()) {
    plan.radius = found["width"][0];
    plan.radius_is_diameter = true;
  }
  // Whoever names a radius wants discs of that radius.
  if (!options.attributes.count("radius") && !options.attributes.count("width")) {
    plan_gaussians(columns, plan);
  }
  return plan;
}

}  // namespace swept
