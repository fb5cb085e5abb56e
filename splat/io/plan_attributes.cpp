#include <algorithm>
#include <array>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "splat/io/attribute_names.h"
#include "splat/io/attributes.h"

namespace swept {
namespace {

using Names = std::vector<std::string>;
using Found = std::vector<std::size_t>;

const Names kAlphas{"alpha", "diffusealpha", "cda", "cd3", "colora", "color3", "rgb3"};
const Names kScales{"scale_0", "scale_1", "scale_2"}, kFlatScales{"scale_0", "scale_1"};
const Names kQuaternion{"rot_0", "rot_1", "rot_2", "rot_3"}, kHarmonic{"f_dc_0", "f_dc_1", "f_dc_2"};
constexpr const char* kPacked = "packed_position";

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

/// The columns of a file by those names that may be asked for: a header can have millions that nobody knows.
/// Of columns with one name the first counts.
class ColumnIndex {
 public:
  ColumnIndex(const std::vector<Column>& columns, const ReadOptions& options) {
    const std::unordered_set<std::string> wanted = names_to_ask_for(options);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (columns[c].is_list) continue;
      if (wanted.count(columns[c].name)) exact_.emplace(columns[c].name, c);
      if (wanted.count(columns[c].number)) numbers_.emplace(columns[c].number, c);
      std::string plain = folded(columns[c].name);
      if (wanted.count(plain)) folded_.emplace(std::move(plain), c);
    }
  }

  /// As it stands in the table, or else whatever folds to it.
  [[nodiscard]] std::optional<std::size_t> usual(const std::string& name) const {
    const auto exact = at(exact_, name);
    return exact ? exact : at(folded_, name);
  }
  /// As a caller says it.
  [[nodiscard]] std::optional<std::size_t> called(const std::string& name) const {
    if (const auto exact = at(exact_, name)) return exact;
    if (const auto number = at(numbers_, name)) return number;
    return at(folded_, folded(name));
  }
  /// All of the names, or nothing.
  [[nodiscard]] Found all(const Names& names) const {
    Found found;
    for (const std::string& name : names) {
      const auto column = usual(name);
      if (!column) return {};
      found.push_back(*column);
    }
    return found;
  }

 private:
  static std::unordered_set<std::string> names_to_ask_for(const ReadOptions& options) {
    std::unordered_set<std::string> wanted{kPacked, "a"};
    for (const AttributeNames& attribute : attribute_names()) {
      for (const Names& names : attribute.usual) wanted.insert(names.begin(), names.end());
    }
    for (const Names* names : {&kAlphas, &kScales, &kQuaternion, &kHarmonic})
      wanted.insert(names->begin(), names->end());
    for (const auto& [attribute, list] : options.attributes) {
      for (const std::string& name : split_names(list)) {
        for (const char* component : {"", "[0]", "[1]", "[2]"}) {
          wanted.insert(name + component);
          wanted.insert(folded(name + component));
        }
      }
    }
    wanted.erase("");
    return wanted;
  }

  using Map = std::unordered_map<std::string, std::size_t>;
  static std::optional<std::size_t> at(const Map& map, const std::string& name) {
    const auto it = map.find(name);
    if (it == map.end()) return std::nullopt;
    return it->second;
  }
  Map exact_, folded_, numbers_;
};

/// Columns the caller asks for by name.
Result<Found> mapped_columns(const std::string& path, const ColumnIndex& index,
                             const AttributeNames& attribute, const std::string& list) {
  if (list.empty()) return Found{};
  Names names = split_names(list);
  // One property that holds three numbers.
  if (attribute.least == 3 && names.size() == 1 && index.called(names[0] + "[0]"))
    names = {names[0] + "[0]", names[0] + "[1]", names[0] + "[2]"};
  const std::string field = std::string("attributes.") + attribute.attribute;
  if (names.size() < attribute.least || names.size() > attribute.most) {
    return Error{path, field,
                 "names " + std::to_string(names.size()) + " properties, must name " +
                     std::to_string(attribute.least)};
  }
  Found found;
  for (const std::string& name : names) {
    const auto column = index.called(name);
    if (!column) return Error{path, field, "the file has no property '" + name + "'"};
    found.push_back(*column);
  }
  return found;
}

std::optional<AttributePlan::Triple> triple(const Found& found) {
  if (found.size() < 3) return std::nullopt;
  return AttributePlan::Triple{found[0], found[1], found[2]};
}

std::optional<std::size_t> single(const Found& found) {
  if (found.empty()) return std::nullopt;
  return found[0];
}

void plan_gaussians(const ColumnIndex& index, AttributePlan& plan) {
  Found scales = index.all(kScales);
  if (scales.empty()) scales = index.all(kFlatScales);
  const Found q = index.all(kQuaternion);
  if (scales.empty() || q.empty()) return;
  plan.log_scale = scales;
  std::copy(q.begin(), q.end(), plan.quaternion.begin());
  if (!plan.color) plan.harmonic = triple(index.all(kHarmonic));
  plan.normal.reset();  // trainers write zeros there; the disc's own normal is the one that counts
  plan.radius.reset();
}

Error no_position(const std::string& path, const std::vector<Column>& columns, const ColumnIndex& index) {
  // Files of PlayCanvas hold four numbers in words of 32 bits, relative to the bounds of chunks.
  if (index.usual(kPacked)) {
    return {path, kPacked,
            "these are splats that PlayCanvas packed, which are read as splats and not as points; convert "
            "them to a "
            "plain splat PLY file, for example with PlayCanvas's splat-transform"};
  }
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  for (const char* name : {"x", "y", "z"}) {
    if (!index.usual(name)) {
      return {
          path, name,
          "the file has no such property: no positions" + (names.empty() ? "" : "; it has " + listed(names))};
    }
  }
  return {path, "attributes.position", "names no properties: no positions"};
}

/// The columns of every attribute, as the caller or the table names them.
Result<std::map<std::string_view, Found>> find_attributes(const std::string& path, const ColumnIndex& index,
                                                          const ReadOptions& options) {
  std::map<std::string_view, Found> found;
  std::string known;
  for (const AttributeNames& names : attribute_names()) {
    found[names.attribute] = {};
    known += (known.empty() ? "" : ", ") + std::string(names.attribute);
  }
  for (const auto& [name, list] : options.attributes) {
    if (!found.count(name))
      return Error{path, "attributes." + name, "is not an attribute; known are " + known};
  }
  for (const AttributeNames& attribute : attribute_names()) {
    Found& columns = found[attribute.attribute];
    if (const auto mapped = options.attributes.find(attribute.attribute);
        mapped != options.attributes.end()) {
      Result<Found> chosen = mapped_columns(path, index, attribute, mapped->second);
      if (!chosen) return chosen.error();
      columns = *std::move(chosen);
      continue;
    }
    for (const Names& names : attribute.usual) {
      if (columns = index.all(names); !columns.empty()) break;
    }
  }
  return found;
}

/// Alpha is opacity too, by another name: the fourth of the colour.
void plan_alpha(const ColumnIndex& index, const ReadOptions& options, const std::vector<Column>& columns,
                const Found& color, AttributePlan& plan) {
  if (plan.opacity || options.attributes.count("opacity")) return;
  if (color.size() == 4) plan.alpha = color[3];
  if (options.attributes.count("color")) return;
  Names names = kAlphas;
  if (!color.empty() && folded(columns[color[0]].name) == "r") names.insert(names.begin(), "a");
  for (const std::string& name : names) {
    if (!plan.alpha) plan.alpha = index.usual(name);
  }
}

}  // namespace

void add_vector_columns(const std::string& name, double full_scale, std::vector<Column>& columns) {
  for (const char* component : {"[0]", "[1]", "[2]"}) columns.push_back({name + component, full_scale});
}

ReadReport AttributePlan::report(const std::vector<Column>& columns) const {
  ReadReport report;
  const auto use = [&](const char* attribute, const auto& some) {
    ReadReport::Use entry{attribute, {}};
    for (const std::size_t c : some) entry.properties.push_back(columns[c].name);
    report.used.push_back(std::move(entry));
  };
  const auto use_one = [&](const char* attribute, const std::optional<std::size_t>& column) {
    if (column) use(attribute, std::array{*column});
  };
  use("position", position);
  if (normal) use("normal", *normal);
  if (velocity) use("velocity", *velocity);
  if (acceleration) use("acceleration", *acceleration);
  if (angular_velocity) use("angular_velocity", *angular_velocity);
  if (color) use("color", *color);
  if (harmonic) use("color", *harmonic);
  use_one("intensity", intensity);
  use_one("alpha", alpha);
  use_one("opacity", opacity);
  use_one(radius_is_diameter ? "width" : "radius", radius);
  if (!log_scale.empty()) {
    use("scale", log_scale);
    use("rotation", quaternion);
  }
  use_one("id", id);
  use_one("time", time);
  const std::vector<bool> is_needed = needed(columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (!is_needed[c]) report.unread.push_back(columns[c].name);
  }
  return report;
}

std::vector<bool> AttributePlan::needed(std::size_t count) const {
  std::vector<bool> is_needed(count, false);
  const auto mark = [&](const auto& some) {
    for (const std::size_t c : some) is_needed[c] = true;
  };
  mark(position);
  for (const auto& vector : {normal, velocity, acceleration, angular_velocity, color, harmonic}) {
    if (vector) mark(*vector);
  }
  for (const auto& scalar : {radius, opacity, alpha, intensity, id, time}) {
    if (scalar) is_needed[*scalar] = true;
  }
  mark(log_scale);
  if (!log_scale.empty()) mark(quaternion);
  return is_needed;
}

Result<AttributePlan> plan_attributes(const std::string& path, const std::vector<Column>& columns,
                                      const ReadOptions& options) {
  const ColumnIndex index(columns, options);
  auto attributes = find_attributes(path, index, options);
  if (!attributes) return attributes.error();
  std::map<std::string_view, Found>& found = *attributes;
  AttributePlan plan;
  const auto position = triple(found["position"]);
  if (!position) return no_position(path, columns, index);
  plan.position = *position;
  plan.normal = triple(found["normal"]);
  plan.velocity = triple(found["velocity"]);
  plan.acceleration = triple(found["acceleration"]);
  plan.angular_velocity = triple(found["angular_velocity"]);
  plan.color = triple(found["color"]);
  plan.opacity = single(found["opacity"]);
  plan_alpha(index, options, columns, found["color"], plan);
  plan.radius = single(found["radius"]);
  if (!plan.radius) {
    plan.radius = single(found["width"]);
    plan.radius_is_diameter = plan.radius.has_value();
  }
  // Whoever names a radius wants discs of that radius.
  if (!options.attributes.count("radius") && !options.attributes.count("width")) plan_gaussians(index, plan);
  if (!plan.radius) plan.radius_is_diameter = false;
  if (!plan.color && !plan.harmonic) plan.intensity = single(found["intensity"]);
  plan.id = single(found["id"]);
  if (options.stamps || options.attributes.count("time")) plan.time = single(found["time"]);
  return plan;
}

}  // namespace swept
