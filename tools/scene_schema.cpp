#include "tools/scene_schema.h"

#include <cctype>
#include <initializer_list>
#include <utility>

#include <nlohmann/json.hpp>

#include "datasets/generators.h"
#include "splat/fields.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

struct Member {
  const char* name;
  Json schema;
  bool required = false;
};

Json object(std::initializer_list<Member> members) {
  Json schema = {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
  for (const Member& member : members) {
    schema["properties"][member.name] = member.schema;
    if (member.required) schema["required"].push_back(member.name);
  }
  return schema;
}

Json described(Json schema, const std::string& text) {
  schema["description"] = text;
  return schema;
}

Json number() { return {{"type", "number"}}; }
Json positive() { return {{"type", "number"}, {"exclusiveMinimum", 0}}; }
Json whole(long long low, long long high) {
  return {{"type", "integer"}, {"minimum", low}, {"maximum", high}};
}
Json boolean() { return {{"type", "boolean"}}; }
Json text() { return {{"type", "string"}, {"minLength", 1}}; }
Json words(const std::vector<std::string>& list) { return {{"enum", list}}; }
Json list(Json items, std::size_t least, std::size_t most = 0) {
  Json schema = {{"type", "array"}, {"items", std::move(items)}, {"minItems", least}};
  if (most > 0) schema["maxItems"] = most;
  return schema;
}
Json vector3() { return list(number(), 3, 3); }
Json any_of(std::initializer_list<Json> schemas) { return {{"anyOf", Json(schemas)}}; }
Json frame() { return {{"type", "number"}, {"minimum", -1e9}, {"maximum", 1e9}}; }

Json number_schema(const FieldNumber& number) {
  Json schema = {{"type", number.whole ? "integer" : "number"}};
  schema[number.above_low ? "exclusiveMinimum" : "minimum"] = number.low;
  schema["maximum"] = number.high;
  return schema;
}

Json field_schema(const Field& field) {
  std::string help(field.help);
  help[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(help[0])));
  if (!field.words.empty()) {
    Json schema = {{"enum", field.words}};
    return described(schema, help);
  }
  if (field.numbers.size() == 1) return described(number_schema(field.numbers[0]), help);
  Json array = {{"type", "array"}, {"items", Json::array()}};
  if (field.count != nullptr)
    array["items"] = number_schema(field.numbers[0]);
  else
    for (const FieldNumber& number : field.numbers) array["items"].push_back(number_schema(number));
  array["minItems"] = std::max<std::size_t>(field.least, 2);
  array["maxItems"] = field.numbers.size();
  // One number does where only it must be given.
  return described(field.least == 1 ? any_of({number_schema(field.numbers[0]), array}) : array, help);
}

void add_fields(Json& root) {
  for (const Field& field : scene_fields()) {
    const std::string group(field.group()), name(field.name());
    Json& parent = group.empty() ? root : root["properties"][group];
    if (parent.is_null()) parent = object({});
    parent["properties"][name] = field_schema(field);
    if (field.with_object) parent["required"].push_back(name);
  }
}

Json fov_schema() {
  return described(
      object({{"axis", words({"vertical", "horizontal", "diagonal"}), true},
              {"degrees", {{"type", "number"}, {"exclusiveMinimum", 0}, {"exclusiveMaximum", 180}}, true}}),
      "Field of view along the named axis of the film");
}

Json intrinsics_schema() {
  return described(object({{"width", positive(), true},
                           {"height", positive(), true},
                           {"fx", positive(), true},
                           {"fy", described(positive(), "fx unless given")},
                           {"cx", described(number(), "The middle unless given")},
                           {"cy", described(number(), "The middle unless given")}}),
                   "Focal lengths and principal point in pixels of pictures of this size");
}

Json lens_schema() {
  return described(
      object({{"aperture", described({{"type", "number"}, {"minimum", 0}},
                                     "Diameter of the opening, world units; 0: a pinhole")},
              {"f_number", described(positive(), "In place of the aperture: focal_length / aperture")},
              {"focal_length", described(positive(), "World units; goes with f_number")},
              {"focus", described(positive(),
                                  "Depth that is in focus, world units; of look-ats by default the target's "
                                  "distance")},
              {"blades", described(whole(3, 64), "Corners of the opening; by default it is round")},
              {"rotation", described(number(), "Of its first corner, clockwise from the right, degrees")},
              {"samples", described(whole(1, 4096),
                                    "Points that the lens is looked through; by default as many as the "
                                    "error asked for takes, or of other methods eight for each pixel of the "
                                    "largest circle of confusion, 64 to 1024")}}),
      "Depth of field by a thin lens");
}

Json camera_schema() {
  const char* const height_help =
      "Of what the film shows, world units, in place of fov: the camera is orthographic";
  const Json matrix = any_of({list(number(), 16, 16), list(list(number(), 4, 4), 4, 4)});
  const Json key =
      object({{"frame", described(frame(), "Increasing from key to key; a lone key may leave it out")},
              {"eye", vector3()},
              {"target", vector3()},
              {"up", described(vector3(), "0 1 0 unless given")},
              {"roll", described(number(), "Degrees by which the camera leans to its right")},
              {"matrix", described(matrix, "Camera to world, row by row, instead of eye and target")},
              {"fov", fov_schema()},
              {"intrinsics", intrinsics_schema()},
              {"height", described(positive(), height_help)},
              {"focus", described(positive(), "Depth that is in focus, world units; goes with a lens")}});
  return described(object({{"fov", fov_schema()},
                           {"intrinsics", intrinsics_schema()},
                           {"height", described(positive(), height_help)},
                           {"near", described(positive(), "Depth below which nothing is seen")},
                           {"lens", lens_schema()},
                           {"keys", list(key, 1), true},
                           {"convention", described(words({"opengl", "opencv"}), "Axes of the matrices")}}),
                   "Keys of one kind, look-ats or matrices, interpolated and held outside");
}

Json transform_schema() {
  const Json rotate = object({{"axis", vector3(), true}, {"degrees", number(), true}});
  const Json scale = any_of({number(), vector3()});
  const Json key =
      object({{"frame", frame()}, {"translate", vector3()}, {"rotate", rotate}, {"scale", scale}});
  return described(
      object({{"keys", list(key, 0)}, {"translate", vector3()}, {"rotate", rotate}, {"scale", scale}}),
      "x becomes translate + rotate(scale x); with keys, or these three alone");
}

Json source_schema() {
  const Json attributes = described({{"type", "object"}, {"additionalProperties", {{"type", "string"}}}},
                                    "Properties of the file by attribute: \"velocity\": \"vx,vy,vz\"");
  const Json range = described(positive(), "What a full channel is stored as");
  const Json space = described(words({"linear", "srgb"}), "How colours are stored");
  Json generator =
      object({{"generator", words(generator_names()), true}, {"points", whole(1, 1'000'000'000), true}});
  generator["additionalProperties"] = described(number(), "A parameter of the shape");
  const Json file = object({{"file", text(), true},
                            {"frame", described(frame(), "When the points are where the file says")},
                            {"attributes", attributes},
                            {"color_range", range},
                            {"color_space", space},
                            {"skip_invalid", described(boolean(), "Leave points out that are not finite")},
                            {"end_file", described(text(), "The same points at end_frame")},
                            {"end_frame", frame()}});
  const Json file_number = whole(-1'000'000'000, 1'000'000'000);
  const Json sequence =
      object({{"sequence", described(text(), "Numbered files: name.%04d.ply, name.####.ply"), true},
              {"first", file_number},
              {"last", file_number},
              {"step", whole(1, 1'000'000'000)},
              {"frames", described(text(), "The numbers of the files as ranges: 1-100x2")},
              {"offset", described(file_number, "File n holds the points at frame n + offset")},
              {"gaps", described(boolean(), "Files may be missing")},
              {"cycle", described(boolean(), "After the last file comes the first")},
              {"attributes", attributes},
              {"color_range", range},
              {"color_space", space}});
  return {{"description", "Generated, a file, or numbered files"},
          {"oneOf", Json::array({generator, file, sequence})}};
}

Json object_schema() {
  return object(
      {{"name", described({{"type", "string"}}, "For messages")},
       {"source", source_schema(), true},
       {"velocity", object({{"unit", words({"per_second", "per_frame", "ignore"}), true}})},
       {"transform", transform_schema()},
       {"color", described(any_of({vector3(), words({"normals"}), object({{"normals", vector3(), true}})}),
                           "Replaces all colours; linear")},
       {"radius", described(positive(), "Makes every disc round, in object units")},
       {"radius_scale", positive()},
       {"facing",
        described(words({"two_sided", "one_sided", "sideless"}),
                  "two_sided: front and back are seen, and are two surfaces where normals or triangles "
                  "say which is which; one_sided: the front alone is seen; sideless: one surface from "
                  "both sides, for normals that point either way")},
       {"segments", described(whole(1, 4096), "As image.segments, for this object")},
       {"stamps", described(object({{"unit", words({"seconds", "frames"})},
                                    {"zero", described(number(), "The stamp of the file's frame")},
                                    {"sensor", transform_schema()}}),
                            "Each point was seen at a time of its own: the file's attribute \"time\"")},
       {"draw", described(words({"splats", "surfels", "triangles"}), "What files are drawn as")},
       {"texture",
        described(text(),
                  "A PNG or EXR that is laid over the triangles of a mesh that has texture coordinates")},
       {"crease_angle", described({{"type", "number"}, {"minimum", 0}, {"maximum", 180}},
                                  "Degrees: triangles that meet at a greater angle do not share a normal")}});
}

}  // namespace

std::string scene_schema() {
  Json root = {{"$schema", "http://json-schema.org/draft-07/schema#"},
               {"title", "Scene file of Swept, version 1"}};
  root.update(
      object({{"$schema", {{"type", "string"}}},
              {"swept", described({{"const", 1}}, "The format's version"), true},
              {"frame", described(frame(), "What is rendered unless the command line says otherwise")},
              {"camera", camera_schema(), true},
              {"objects", list(object_schema(), 0), true}}));
  add_fields(root);
  return root.dump(2) + '\n';
}

}  // namespace swept
