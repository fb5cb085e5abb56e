#include "splat/io/scene_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

#include "splat/io/camera_file.h"
#include "splat/io/guarded.h"
#include "splat/io/json_text.h"
#include "splat/io/scene_parsing.h"

namespace swept {
namespace {

using io::JsonNode;

constexpr long long format_version = 1;

Result<std::string> read_text(const std::string& path) {
  // 100,000 camera keys with matrices take 40 MB; what is larger is not a scene file.
  constexpr std::size_t max_bytes = std::size_t{256} << 20;
  std::error_code code;
  if (std::filesystem::is_directory(path, code))
    return Error{path, "", "is a folder; files in it are named as one, such as FOLDER/name.%04d.ply"};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path, "", "cannot open the scene file", ErrorKind::not_found};
  std::string text;
  std::array<char, 1 << 16> block;
  while (file.read(block.data(), block.size()), file.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
    if (text.size() > max_bytes) return Error{path, "", "too large for a scene file (256 MiB at most)"};
  }
  if (file.bad()) return Error{path, "", "cannot read the scene file", ErrorKind::device};
  return text;
}

/// What is neither a scene nor of a name that says what else it is.
Status refuse_other_files(const std::string& path, const std::string& text) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (extension == ".json" || first == std::string::npos || text[first] == '{') return Done{};
  std::string reason =
      "is no scene file, which is a JSON object, and its extension is none of point files (.ply .pcd .obj "
      ".off .xyz "
      ".txt .asc .csv .pts .xyzn .xyzrgb) or of splats (.ply .splat .spz .sog .glb .gltf)";
  struct Others {
    std::string_view extensions, advice;
  };
  constexpr Others others[] = {
      {" .las .laz .e57 ", "PDAL and CloudCompare save them as .ply"},
      {" .bgeo .geo .abc .usd .usda .usdc .usdz .vdb ", "Houdini and Blender save their points as .ply"},
      {" .blend .fbx .stl .dae .3mf .3ds ", "Blender saves them as .ply or .obj"},
      {" .ksplat .splatv .rad .lcc ", "SuperSplat and splat-transform save them as .ply or .spz"},
      {" .mp4 .mov .gif .png .jpg .jpeg .exr ", "points, meshes and splats are"}};
  for (const Others& other : others)
    if (!extension.empty() && other.extensions.find(" " + extension + " ") != std::string_view::npos)
      reason = extension + " files are not read; " + std::string(other.advice);
  return Error{path, "", reason, ErrorKind::unsupported};
}

void override_fields(const FieldValues& values, const std::string& path, Scene& scene) {
  for (const auto& [pointer, numbers] : values) {
    const Field* field = find_field(pointer);
    if (field == nullptr)
      throw Error{path, pointer, "there is no such field to override", ErrorKind::argument};
    if (const Status legal = field->legal(numbers); !legal)
      throw Error{path, legal.error().field, legal.error().reason, legal.error().kind};
    field->set(scene, numbers);
  }
}

const char* name_of(DrawAs draw) {
  return draw == DrawAs::splats ? "splats" : draw == DrawAs::surfels ? "surfels" : "triangles";
}

/// What the file and the overrides lead to, whatever of it is spelt out in the file.
std::string canonical(const Scene& scene, const SceneOverrides& overrides) {
  nlohmann::json text = {overrides.points_scale};
  if (overrides.draw) text.push_back(name_of(*overrides.draw));
  if (!overrides.texture.empty()) text.push_back({"texture", true});
  if (overrides.crease_angle) text.push_back({"crease_angle", *overrides.crease_angle});
  if (overrides.camera.any()) text.push_back({"camera", overrides.camera.numbers()});
  if (overrides.up) text.push_back({overrides.up->x(), overrides.up->y(), overrides.up->z()});
  for (const Field& field : scene_fields()) text.push_back({field.pointer, field.get(scene)});
  return text.dump();
}

void parse_version(const JsonNode& root) {
  if (!root.is_object()) root.fail("a scene file is one JSON object");
  const auto version = root.find("swept");
  // What nerfstudio and instant-ngp call them.
  if (!version && (root.find("frames") || root.find("camera_path")))
    root.fail("no scene file, but one of cameras: swept render POINTS --camera FILE looks through them");
  if (!version) root.fail("no scene file: the key \"swept\", the format's version, is missing");
  const double number = version->number();
  if (number > static_cast<double>(format_version))
    version->fail("the file is of a newer version than this program reads, which is 1");
  if (number != static_cast<double>(format_version)) version->fail("the only version there is is 1");
}

void parse_scene(const JsonNode& root, const std::string& folder, const SceneOverrides& overrides,
                 Scene& scene, std::vector<ObjectSource>& sources) {
  parse_version(root);
  std::vector<std::string_view> known = {"$schema", "swept", "frame", "camera", "objects"};
  for (const std::string_view name : io::root_field_names()) known.push_back(name);
  root.expect_keys(known);
  // For editors.
  if (const auto schema = root.find("$schema")) static_cast<void>(schema->string());
  io::parse_fields(root, scene);
  // Before the camera, whose field of view may be that of another axis.
  override_fields(overrides.fields, root.file(), scene);
  scene.frame = 1.0;
  if (const auto node = root.find("frame")) scene.frame = node->number();
  scene.camera = parse_camera(root.require("camera"), scene.film);
  if (overrides.up) {
    if (scene.camera.look_ats.empty())
      throw Error{root.file(), "/camera/keys", "a matrix has its own up, so that no other can be given"};
    for (LookAtKey& key : scene.camera.look_ats) key.up = *overrides.up;
  }
  if (overrides.camera.any()) io::override_camera(overrides.camera, root.file(), scene.camera);
  for (const JsonNode& node : root.require("objects").elements()) {
    io::ParsedObject parsed = io::parse_object(node, folder, scene.frame);
    scene.objects.push_back(std::move(parsed.object));
    sources.push_back(std::move(parsed.source));
  }
  if (overrides.fields.contains("/image/segments"))
    for (Object& object : scene.objects) object.segments = 0;
}

/// Frames per second by the overrides, or by what of a scene file has been read.
double rate_of(const SceneOverrides& overrides, const nlohmann::json& document) {
  const auto found = overrides.fields.find("/fps");
  std::vector<double> fps = found == overrides.fields.end() ? std::vector<double>() : found->second;
  if (const auto own = document.find("fps"); fps.empty() && own != document.end()) {
    if (own->is_number()) fps = {own->get<double>()};
    if (own->is_array())
      for (const nlohmann::json& number : *own)
        fps.push_back(number.is_number() ? number.get<double>() : 0.0);
  }
  const double rate = fps.empty() ? 24.0 : fps[0] / (fps.size() > 1 ? fps[1] : 1.0);
  // What is no rate is refused where the scene is read.
  return rate > 0.0 && std::isfinite(rate) ? rate : 24.0;
}

/// Turns a camera of glTF into the axes that splats of glTF are read into.
void turn_to_splats(nlohmann::json& camera) {
  for (nlohmann::json& key : camera["keys"]) {
    // Rows of the matrix are the world's axes.
    for (std::size_t i = 0; i < 8; ++i) key["matrix"][i] = -key["matrix"][i].get<double>();
  }
}

bool draws_gltf(const nlohmann::json& document) {
  const auto objects = document.find("objects");
  if (objects == document.end() || !objects->is_array()) return false;
  return std::any_of(objects->begin(), objects->end(), [](const nlohmann::json& object) {
    const nlohmann::json::json_pointer file("/source/file");
    if (!object.is_object() || !object.contains(file) || !object[file].is_string()) return false;
    const std::string name = object[file].get<std::string>();
    return name.ends_with(".glb") || name.ends_with(".gltf");
  });
}

/// Puts the camera of a file in place of the scene's, whose near plane and lens stay. What the scene has of a
/// film stays too.
void replace_camera(const SceneOverrides& overrides, nlohmann::json& document,
                    std::vector<std::string>& notes) {
  const double fps = document.is_object() ? rate_of(overrides, document) : 24.0;
  Result<io::CameraFile> file = io::read_camera_file(overrides.camera_file, fps);
  if (!file) throw file.error();
  if (document.is_object()) {
    if (file->gltf_axes && draws_gltf(document)) turn_to_splats(file->camera);
    if (const auto old = document.find("camera"); old != document.end() && old->is_object())
      for (const char* own : {"near", "lens"})
        if (old->contains(own)) file->camera[own] = (*old)[own];
    document["camera"] = std::move(file->camera);
  }
  notes.insert(notes.end(), file->notes.begin(), file->notes.end());
}

/// SceneFile::members() below `at`.
void count_members(const nlohmann::json& value, const std::string& at,
                   std::map<std::string, std::size_t>& members) {
  for (const auto& [name, member] : value.items()) {
    const std::string pointer = io::join_pointer(at, name);
    const bool keys = name == "keys" && member.is_array();
    members[pointer] += keys ? member.size() : 1;
    if (keys)
      for (const nlohmann::json& key : member)
        if (key.is_object()) count_members(key, pointer + "/*", members);
    if (pointer == "/objects" && member.is_array())
      for (std::size_t i = 0; i < member.size(); ++i)
        if (member[i].is_object()) count_members(member[i], pointer + '/' + std::to_string(i), members);
    if (member.is_object()) count_members(member, pointer, members);
  }
}

}  // namespace

Result<SceneFile> read_scene_file(const std::string& path, const SceneOverrides& overrides) {
  return io::guarded(path, [&]() -> Result<SceneFile> {
    const Result<std::string> text = read_text(path);
    if (!text) return text.error();
    if (Status other = refuse_other_files(path, *text); !other) return other.error();
    return scene_from_text(*text, path, overrides);
  });
}

Result<SceneFile> scene_from_text(const std::string& text, const std::string& path,
                                  const SceneOverrides& overrides, std::vector<std::string> notes) {
  return io::guarded(path, [&]() -> Result<SceneFile> {
    Result<nlohmann::json> document = io::parse_json(path, text);
    if (!document) return document.error();
    SceneFile file;
    if (document->is_object()) count_members(*document, "", file.members_);
    if (!overrides.camera_file.empty()) replace_camera(overrides, *document, notes);
    file.path_ = path;
    file.notes_ = std::move(notes);
    parse_scene(JsonNode(*document, path), std::filesystem::path(path).parent_path().string(), overrides,
                file.scene_, file.sources_);
    if (!(overrides.points_scale > 0.0) || !std::isfinite(overrides.points_scale))
      return Error{path, "points_scale", "must be a finite number above 0", ErrorKind::argument};
    file.points_scale_ = overrides.points_scale;
    if (overrides.draw)
      for (ObjectSource& source : file.sources_)
        if (std::holds_alternative<FileSource>(source.points) ||
            (overrides.draw != DrawAs::splats && std::holds_alternative<SequenceSource>(source.points)))
          source.draw = overrides.draw;
    if (!overrides.texture.empty()) {
      bool used = false;
      for (ObjectSource& source : file.sources_) {
        if (source.draw != DrawAs::triangles) continue;
        source.texture = overrides.texture;
        used = true;
      }
      if (!used)
        return Error{overrides.texture, "", "is a texture, and nothing is drawn as triangles",
                     ErrorKind::argument};
    }
    if (overrides.crease_angle) {
      if (!(*overrides.crease_angle >= 0.0 && *overrides.crease_angle <= 180.0))
        return Error{"", "crease_angle", "must be between 0 and 180 degrees", ErrorKind::argument};
      bool used = false;
      for (ObjectSource& source : file.sources_) {
        if (source.draw != DrawAs::triangles) continue;
        source.crease_angle = overrides.crease_angle;
        used = true;
      }
      if (!used)
        return Error{"", "crease_angle", "is of triangles, and nothing is drawn as such",
                     ErrorKind::argument};
    }
    if (const Status valid = file.scene_.validate(); !valid)
      return Error{path, valid.error().field, valid.error().reason, in_a_file(valid.error().kind)};
    document->erase("$schema");
    file.canonical_ = document->dump() + '\n' + canonical(file.scene_, overrides);
    Scene whole = file.scene_;
    Film& film = whole.film;
    film.crop_x = film.crop_y = film.crop_width = film.crop_height = 0;
    if (const auto own = document->find("film"); own != document->end() && own->is_object())
      own->erase("crop");
    file.canonical_whole_ = document->dump() + '\n' + canonical(whole, overrides);
    return file;
  });
}

}  // namespace swept
