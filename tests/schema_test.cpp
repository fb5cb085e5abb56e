// The schema that editors check scene files by: it knows the keys that the reader knows, no more and no less,
// and takes the scenes that are read.
#include "tools/scene_schema.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/command.h"
#include "tests/scene_text.h"

namespace swept {
namespace {

using nlohmann::json;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Whether `value` is as `schema` has it, by the words of JSON schemas that ours uses; others are a failure.
class Validator {
 public:
  [[nodiscard]] bool valid(const json& schema, const json& value) const {
    return std::all_of(schema.items().begin(), schema.items().end(),
                       [&](const auto& rule) { return obeys(rule.key(), rule.value(), schema, value); });
  }

 private:
  static bool is_type(const std::string& type, const json& value) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "number") return value.is_number();
    EXPECT_EQ(type, "integer");
    return value.is_number() && value.get<double>() == std::floor(value.get<double>());
  }

  [[nodiscard]] bool obeys(const std::string& rule, const json& wanted, const json& schema,
                           const json& value) const {
    const auto count = [&](const json& schemas) {
      return std::count_if(schemas.begin(), schemas.end(),
                           [&](const json& one) { return valid(one, value); });
    };
    if (rule == "title" || rule == "description" || rule == "$schema") return true;
    if (rule == "type") return is_type(wanted.get<std::string>(), value);
    if (rule == "const") return value == wanted;
    if (rule == "enum") return std::find(wanted.begin(), wanted.end(), value) != wanted.end();
    if (rule == "anyOf") return count(wanted) >= 1;
    if (rule == "oneOf") return count(wanted) == 1;
    if (rule == "minLength") return !value.is_string() || value.get<std::string>().size() >= wanted;
    if (rule == "minItems") return !value.is_array() || value.size() >= wanted;
    if (rule == "maxItems") return !value.is_array() || value.size() <= wanted;
    if (rule == "minimum") return !value.is_number() || value >= wanted;
    if (rule == "maximum") return !value.is_number() || value <= wanted;
    if (rule == "exclusiveMinimum") return !value.is_number() || value > wanted;
    if (rule == "exclusiveMaximum") return !value.is_number() || value < wanted;
    if (rule == "required")
      return std::all_of(wanted.begin(), wanted.end(),
                         [&](const json& name) { return value.contains(name); });
    if (rule == "items") {
      for (std::size_t i = 0; value.is_array() && i < value.size(); ++i)
        if (!valid(wanted.is_array() ? wanted.at(std::min(i, wanted.size() - 1)) : wanted, value[i]))
          return false;
      return true;
    }
    if (rule == "properties") {
      for (const auto& [name, member] : wanted.items())
        if (value.is_object() && value.contains(name) && !valid(member, value[name])) return false;
      return true;
    }
    if (rule == "additionalProperties") {
      const json known = schema.value("properties", json::object());
      for (const auto& [name, member] : value.items()) {
        if (!value.is_object() || known.contains(name)) continue;
        if (wanted.is_boolean() ? !wanted.get<bool>() : !valid(wanted, member)) return false;
      }
      return true;
    }
    ADD_FAILURE() << "the test does not know the rule " << rule;
    return false;
  }
};

json schema() { return json::parse(scene_schema()); }

TEST(Schema, StandsInDatasetsAsTheCommandPrintsIt) {
  EXPECT_TRUE(text_of(SWEPT_SCENES "/scene.schema.json") == scene_schema())
      << "swept schema > datasets/scene.schema.json";
  EXPECT_TRUE(test::run_command(SWEPT_COMMAND " schema").out == scene_schema());
}

TEST(Schema, TakesTheScenesThatThereAre) {
  std::size_t scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SWEPT_SCENES)) {
    if (entry.path().extension() != ".json" || entry.path().stem().extension() == ".schema") continue;
    EXPECT_TRUE(Validator().valid(schema(), json::parse(text_of(entry.path())))) << entry.path();
    ++scenes;
  }
  EXPECT_GE(scenes, 7u);
  std::string manual = text_of(SWEPT_SCENES "/README.md");
  manual.erase(0, manual.find("```json\n") + 8);
  manual.erase(manual.find("```"));
  EXPECT_TRUE(Validator().valid(schema(), json::parse(manual)));
}

/// A scene with something at every place that takes keys.
json full_scene() {
  return json::parse(R"({"swept": 1, "film": {"width": 64, "height": 48}, "shutter": {"open": 0, "close": 1},
    "fps": [24000, 1001], "background": [0, 0, 0], "image": {"delta": 3},
    "camera": {"fov": {"axis": "vertical", "degrees": 40},
               "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0],
                         "intrinsics": {"width": 640, "height": 480, "fx": 500}}]},
    "objects": [{"source": {"file": "a.ply", "attributes": {"velocity": "a,b,c"}}, "velocity": {"unit": "ignore"},
                 "transform": {"keys": [{"rotate": {"axis": [0, 1, 0], "degrees": 5}, "scale": 2}]}},
                {"source": {"sequence": "a.%04d.ply"}, "color": "normals",
                 "transform": {"rotate": {"axis": [0, 1, 0], "degrees": 5}, "scale": [1, 2, 3]}},
                {"source": {"generator": "sphere", "points": 9, "radius": 2}, "color": [1, 0, 0]},
                {"source": {"file": "b.ply"}, "color": {"normals": [0, 0, 1]}}]})");
}

/// The keys that the reader lists when it meets one that it does not know.
std::set<std::string> known_to_the_reader(const json& scene) {
  const Result<SceneFile> file = scene_from_text(scene.dump(), "scene.json");
  EXPECT_FALSE(file.ok());
  const std::string text = file.ok() ? "" : file.error().reason;
  std::set<std::string> names;
  const std::size_t list = text.find("known here:");
  EXPECT_NE(list, std::string::npos) << text;
  for (std::size_t at = text.find('"', list); at < text.size();) {
    const std::size_t end = text.find('"', at + 1);
    names.insert(text.substr(at + 1, end - at - 1));
    at = text.find('"', end + 1);
  }
  return names;
}

TEST(Schema, KnowsTheKeysOfTheReader) {
  const json all = schema();
  const json& properties = all["properties"];
  const json& camera = properties["camera"]["properties"];
  const json& object = properties["objects"]["items"]["properties"];
  const json& transform = object["transform"]["properties"];
  const json& sources = object["source"]["oneOf"];
  const std::pair<const char*, json> places[] = {{"", all},
                                                 {"/film", properties["film"]},
                                                 {"/shutter", properties["shutter"]},
                                                 {"/image", properties["image"]},
                                                 {"/camera", properties["camera"]},
                                                 {"/camera/fov", camera["fov"]},
                                                 {"/camera/keys/0", camera["keys"]["items"]},
                                                 {"/camera/keys/0/intrinsics", camera["intrinsics"]},
                                                 {"/objects/0", properties["objects"]["items"]},
                                                 {"/objects/3/color", object["color"]["anyOf"][2]},
                                                 {"/objects/0/source", sources[1]},
                                                 {"/objects/1/source", sources[2]},
                                                 {"/objects/0/velocity", object["velocity"]},
                                                 {"/objects/0/transform/keys/0", transform["keys"]["items"]},
                                                 {"/objects/0/transform/keys/0/rotate", transform["rotate"]},
                                                 {"/objects/1/transform", object["transform"]}};
  for (const auto& [place, own] : places) {
    json scene = full_scene();
    scene[json::json_pointer(place)]["qqqqqqqq"] = 1;
    EXPECT_FALSE(Validator().valid(all, scene)) << place;
    std::set<std::string> names;
    for (const auto& [name, member] : own["properties"].items()) names.insert(name);
    EXPECT_EQ(names, known_to_the_reader(scene)) << place;
  }
}

TEST(Schema, MarksWhatTheReaderRefuses) {
  const json good = full_scene();
  EXPECT_TRUE(Validator().valid(schema(), good));
  EXPECT_TRUE(scene_from_text(good.dump(), "scene.json").ok());
  const std::pair<const char*, json> faults[] = {{"/swept", 2},
                                                 {"/film/width", 0},
                                                 {"/film/width", 1.5},
                                                 {"/fps", json{24, 1, 1}},
                                                 {"/fps", 0},
                                                 {"/background", json{0, 0}},
                                                 {"/background", json{0, 0, 0, 2}},
                                                 {"/image/delta", 0},
                                                 {"/image/coverage", "sofd"},
                                                 {"/camera/fov/axis", "verticle"},
                                                 {"/camera/fov/degrees", 180},
                                                 {"/camera/keys", json::array()},
                                                 {"/camera/keys/0/intrinsics/fx", 0},
                                                 {"/objects/0/source", json::object()},
                                                 {"/objects/0/velocity/unit", "per_hour"},
                                                 {"/objects/0/segments", 0},
                                                 {"/objects/1/color", "normal"},
                                                 {"/objects/3/color/normals", json{0, 1}},
                                                 {"/$schema", 1},
                                                 {"/objects", 1}};
  for (const auto& [pointer, value] : faults) {
    json scene = good;
    scene[json::json_pointer(pointer)] = value;
    EXPECT_FALSE(Validator().valid(schema(), scene)) << pointer << ' ' << value;
    EXPECT_FALSE(scene_from_text(scene.dump(), "scene.json").ok()) << pointer << ' ' << value;
  }
  for (const char* pointer : {"/swept", "/camera", "/objects", "/film/height", "/objects/0/source"}) {
    json scene = good;
    const json::json_pointer place(pointer);
    scene[place.parent_pointer()].erase(place.back());
    EXPECT_FALSE(Validator().valid(schema(), scene)) << pointer;
    EXPECT_FALSE(scene_from_text(scene.dump(), "scene.json").ok()) << pointer;
  }
}

TEST(Schema, NamingItChangesNoPicture) {
  json scene = full_scene();
  scene["objects"] = json::array();
  const auto plain = scene_from_text(scene.dump(), "scene.json");
  scene["$schema"] = "scene.schema.json";
  const auto named = scene_from_text(scene.dump(), "scene.json");
  ASSERT_TRUE(plain.ok() && named.ok());
  EXPECT_EQ(*plain->hash(1.0), *named->hash(1.0));
}

}  // namespace
}  // namespace swept
