#include "splat/io/obj_materials.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "splat/io/read_report.h"
#include "splat/io/texture_file.h"
#include "splat/srgb.h"

namespace swept::io {
namespace {

namespace fs = std::filesystem;

/// A name of a file in the folder of another, as any system's tools write it.
std::string beside(const std::string& path, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return (fs::path(path).parent_path() / name).lexically_normal().string();
}

std::string extension_of(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_texture(const std::string& path) {
  const std::string extension = extension_of(path);
  return extension == ".png" || extension == ".exr";
}

/// What all MTL files say; pairs of a material and the file that has it.
struct Library {
  std::map<std::string, std::pair<MtlMaterial, std::string>> materials;
  std::size_t found = 0;  ///< files
  std::vector<std::string> notes;
};

Result<Library> read_library(const std::string& obj_path, const MaterialNames& names,
                             KeptFiles<MtlFile>& kept) {
  Library library;
  for (const std::string& name : names.files) {
    const std::string path = beside(obj_path, name);
    bool opened = true;
    const Result<std::shared_ptr<const MtlFile>> file =
        kept.get(path, [&](const std::string&) -> Result<MtlFile> {
          const Result<std::string> bytes = read_bytes(path);
          opened = bytes.ok();
          if (!bytes) return bytes.error();
          return read_mtl(path, *bytes);
        });
    if (!opened) {
      library.notes.push_back("materials are not read: " + file.error().message());
      continue;
    }
    if (!file) return file.error();
    ++library.found;
    for (const MtlMaterial& material : (*file)->materials)
      library.materials.try_emplace(material.name, material, path);
    if (!(*file)->unread.empty()) library.notes.push_back(path + ": not read: " + listed((*file)->unread));
  }
  return library;
}

float light(double stored, ColorSpace space) {
  return static_cast<float>(space == ColorSpace::srgb ? srgb_to_linear(stored) : stored);
}

}  // namespace

Result<ObjMaterials> load_obj_materials(const std::string& obj_path, const MaterialNames& names,
                                        ColorSpace space, bool own_colors, MaterialFiles& kept) {
  ObjMaterials loaded;
  if (names.names.empty()) return loaded;
  kept.libraries.begin_round();
  kept.textures.begin_round();
  Result<Library> library = read_library(obj_path, names, kept.libraries);
  if (!library) return library.error();
  loaded.notes = std::move(library->notes);
  if (names.files.empty()) loaded.notes.push_back("materials are not read: usemtl without a mtllib");
  if (library->found == 0) return loaded;
  std::map<std::string, std::shared_ptr<const Texture>> textures;
  std::vector<std::string> unknown;
  for (const std::string& name : names.names) {
    Material& material = loaded.materials.emplace_back();
    material.name = name;
    const auto found = library->materials.find(name);
    if (found == library->materials.end()) {
      if (!name.empty()) unknown.push_back(name);
      continue;
    }
    const auto& [stored, mtl_path] = found->second;
    for (int c = 0; c < 3 && !own_colors; ++c) material.color[c] = light(stored.color[c], space);
    material.opacity = static_cast<float>(stored.opacity);
    if (stored.color_map.empty()) continue;
    const std::string path = beside(mtl_path, stored.color_map);
    if (!is_texture(path)) {
      loaded.notes.push_back("map_Kd of material " + printable(name) +
                             " is not read: textures are .png and .exr, and it is " +
                             printable(stored.color_map));
      continue;
    }
    std::shared_ptr<const Texture>& texture = textures[path];
    if (!texture) {
      const Result<std::shared_ptr<const Texture>> picture = kept.textures.get(path, read_texture);
      if (!picture) {
        Error error = picture.error();
        error.reason += ", which is map_Kd of material " + printable(name) + " of " + mtl_path;
        return error;
      }
      texture = *picture;
      loaded.notes.push_back("texture " + std::to_string(texture->width) + " x " +
                             std::to_string(texture->height) + ": " + path);
    }
    material.texture = texture;
    loaded.textured = true;
  }
  for (std::size_t t = 0; t < names.of_triangle.size(); ++t)
    if (const Material& material = loaded.materials[names.of_triangle[t]];
        material.texture && names.on_texture[t] == 0)
      return Error{obj_path, "face",
                   "one of material " + printable(material.name) +
                       " has corners without a place (vt) on the texture that it has",
                   ErrorKind::malformed};
  if (!unknown.empty()) loaded.notes.push_back("white, as no mtllib has them: materials " + listed(unknown));
  if (own_colors)
    loaded.notes.push_back("vertices have colours, which stand in place of those of materials (Kd)");
  return loaded;
}

bool draws_materials(const ObjectSource& source) {
  return source.draw == DrawAs::triangles && source.texture.empty() && !source.color &&
         !source.color_by_normals;
}

Status take_materials(const ObjectSource& source, LoadedCloud& loaded, MaterialFiles& kept,
                      std::vector<Material>& materials, std::vector<std::uint32_t>& material_of,
                      std::vector<TextureCorners>& texture_corners) {
  const auto* file = std::get_if<FileSource>(&source.points);
  const auto* sequence = std::get_if<SequenceSource>(&source.points);
  std::optional<ColorSpace> space;
  if (file != nullptr) space = file->stored.space;
  if (sequence != nullptr) space = sequence->stored.space;
  Result<ObjMaterials> found =
      load_obj_materials(loaded.materials_of, loaded.materials, space.value_or(ColorSpace::linear),
                         !loaded.cloud.color.empty(), kept);
  if (!found) return found.error();
  loaded.notes.insert(loaded.notes.end(), found->notes.begin(), found->notes.end());
  if (found->materials.empty()) return Done{};
  std::erase(loaded.report.assumed, "there are no colours: white");
  materials = std::move(found->materials);
  material_of = std::move(loaded.materials.of_triangle);
  if (found->textured) texture_corners = std::move(loaded.texture_corners);
  return Done{};
}

std::vector<std::string> files_of_obj_materials(const std::string& obj_path) {
  std::vector<std::string> files;
  if (extension_of(obj_path) != ".obj") return files;
  const Result<std::string> bytes = read_bytes(obj_path);
  if (!bytes) return files;
  ObjMaterialNames names;
  LineScanner lines(*bytes, "", '\\');
  while (lines.next_line()) {
    const std::string_view keyword = lines.next_token();
    if (keyword == "mtllib") names.add_files(lines);
    if (keyword == "usemtl") names.use(lines);
  }
  for (const std::string& name : names.finish().files) {
    const std::string path = beside(obj_path, name);
    const Result<std::string> mtl = read_bytes(path);
    if (!mtl) continue;
    files.push_back(path);
    const Result<MtlFile> file = read_mtl(path, *mtl);
    if (!file) continue;
    for (const MtlMaterial& material : file->materials)
      if (const std::string map = beside(path, material.color_map);
          !material.color_map.empty() && is_texture(map) && fs::is_regular_file(map))
        files.push_back(map);
  }
  return files;
}

}  // namespace swept::io
