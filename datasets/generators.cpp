#include "datasets/generators.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "datasets/shape.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

using datasets::Shape;

std::vector<Shape> all_shapes() {
  using namespace datasets;
  return {box_shape(),  disc_shape(),  fan_shape(),    head_shape(),   knot_shape(),
          page_shape(), plane_shape(), ribbon_shape(), sparks_shape(), sphere_shape()};
}

// Unit length is not asked of the light, so that a scene file can say 1, 2, 1.
std::vector<GeneratorParameter> shared_parameters() {
  return {{"seed", 1, 0, 9007199254740992.0, true, "turns the sampling pattern and reseeds what is random"},
          {"red", 1, 0, 100, false, "factor on the colour's red, linear"},
          {"green", 1, 0, 100, false, "factor on the colour's green, linear"},
          {"blue", 1, 0, 100, false, "factor on the colour's blue, linear"},
          {"ambient", 0.3, 0, 1, false, "share of the light that comes from everywhere; 1: no shading"},
          {"light_x", 0.5, -1000, 1000, false, "direction to the light, object space, any length"},
          {"light_y", 0.7, -1000, 1000, false, "direction to the light, object space, any length"},
          {"light_z", 0.6, -1000, 1000, false, "direction to the light, object space, any length"}};
}

std::vector<GeneratorParameter> parameters_of(const Shape& shape) {
  std::vector<GeneratorParameter> list = shape.parameters;
  const std::vector<GeneratorParameter> shared = shared_parameters();
  list.insert(list.end(), shared.begin(), shared.end());
  return list;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// As short as the number is: 0.05, not 0.050000.
std::string plain(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

Result<Shape> find_shape(const std::string& name) {
  for (Shape& shape : all_shapes()) {
    if (shape.name == name) return std::move(shape);
  }
  return Error{"", "generator", "unknown shape \"" + name + "\"; known are " + joined(generator_names())};
}

Result<std::map<std::string, double>> complete(const std::vector<GeneratorParameter>& known,
                                               const std::map<std::string, double>& given) {
  std::map<std::string, double> values;
  for (const GeneratorParameter& parameter : known) values[parameter.name] = parameter.fallback;
  for (const auto& [name, value] : given) {
    const std::string& wanted = name;
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const GeneratorParameter& p) { return p.name == wanted; });
    if (found == known.end()) {
      std::vector<std::string> names;
      for (const GeneratorParameter& parameter : known) names.push_back(parameter.name);
      return Error{"", name, "unknown parameter; this shape takes " + joined(names)};
    }
    if (!(value >= found->low && value <= found->high)) {
      return Error{"", name, "must be from " + plain(found->low) + " to " + plain(found->high)};
    }
    if (found->whole && value != std::floor(value)) return Error{"", name, "must be a whole number"};
    values[name] = value;
  }
  if (values["light_x"] == 0 && values["light_y"] == 0 && values["light_z"] == 0) {
    return Error{"", "light_x", "light_x, light_y and light_z are all zero, which is no direction"};
  }
  return values;
}

}  // namespace

std::vector<std::string> generator_names() {
  std::vector<std::string> names;
  for (const Shape& shape : all_shapes()) names.push_back(shape.name);
  return names;
}

Result<std::vector<GeneratorParameter>> generator_parameters(const std::string& shape) {
  const Result<Shape> found = find_shape(shape);
  if (!found) return found.error();
  return parameters_of(*found);
}

Result<SurfelCloud> generate(const std::string& shape, std::size_t points,
                             const std::map<std::string, double>& parameters) {
  return without_throwing("for the points", [&]() -> Result<SurfelCloud> {
    const Result<Shape> found = find_shape(shape);
    if (!found) return found.error();
    if (points < 1 || points > kMaxGeneratedPoints) {
      return Error{"", "points", "must be from 1 to " + std::to_string(kMaxGeneratedPoints)};
    }
    Result<std::map<std::string, double>> values = complete(parameters_of(*found), parameters);
    if (!values) return values.error();
    try {
      Result<SurfelCloud> cloud = found->build(datasets::Request(points, *std::move(values)));
      if (cloud && found->surface) cloud->oriented.assign(cloud->size(), 1);
      return cloud;
    } catch (const std::bad_alloc&) {
      return Error{"", "points", "not enough memory for " + std::to_string(points) + " points",
                   ErrorKind::out_of_memory};
    }
  });
}

}  // namespace swept
