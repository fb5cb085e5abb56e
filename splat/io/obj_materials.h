// Materials of OBJ files: which faces have which, and what MTL files say of them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "splat/export.h"
#include "splat/io/cloud_source.h"
#include "splat/io/file_bytes.h"
#include "splat/io/kept_files.h"
#include "splat/io/point_file.h"
#include "splat/io/scene_file.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// Lines mtllib and usemtl, and the triangles between them.
class ObjMaterialNames {
 public:
  /// The rest of the line: names of files end in .mtl, and may have blanks in them.
  void add_files(LineScanner& lines);
  void use(LineScanner& lines);
  /// All triangles so far that have no material yet have the present one.
  void end_face(std::size_t triangles) { names_.of_triangle.resize(triangles, current_); }
  [[nodiscard]] std::size_t libraries() const { return names_.files.size(); }
  /// Nothing where no face has a material.
  [[nodiscard]] MaterialNames finish();

 private:
  MaterialNames names_{{}, {""}, {}, {}};
  std::map<std::string, std::uint32_t, std::less<>> index_{{"", 0}};
  std::uint32_t current_ = 0;
};

/// A material as an MTL file has it.
struct MtlMaterial {
  std::string name;
  Eigen::Vector3d color = Eigen::Vector3d::Ones();  ///< Kd as stored
  double opacity = 1.0;                             ///< d, or else 1 − Tr; [0, 1]
  std::string color_map;                            ///< map_Kd, as the file says it; empty: none
};
struct MtlFile {
  std::vector<MtlMaterial> materials;
  std::vector<std::string> unread;  ///< statements, by name
};
/// Errors name the file and the line.
[[nodiscard]] Result<MtlFile> read_mtl(const std::string& path, std::string_view bytes);

namespace io {

struct ObjMaterials {
  std::vector<Material> materials;  ///< of each of MaterialNames::names; empty: none could be found
  bool textured = false;            ///< any has a texture
  std::vector<std::string> notes;
};

/// What an object's materials were last read from.
struct MaterialFiles {
  KeptFiles<MtlFile> libraries;
  KeptFiles<Texture> textures;
};

/// What the MTL files beside an OBJ file say of its materials; of two of one name the first counts.
/// `own_colors`: vertices have colours, which stand in place of Kd. A file that is not there and a texture of
/// another kind than PNG and EXR are told in the notes. Files that `kept` has as they are now are not read
/// again. Errors: a malformed MTL file, a texture that cannot be read, or that faces have no place on.
[[nodiscard]] Result<ObjMaterials> load_obj_materials(const std::string& obj_path, const MaterialNames& names,
                                                      ColorSpace space, bool own_colors, MaterialFiles& kept);

/// Whether the materials of a source's files say what its triangles look like, and nothing else does.
[[nodiscard]] bool draws_materials(const ObjectSource& source);

/// Moves what `loaded` has of materials to where an object has it; nothing where there are no MTL files. Adds
/// notes.
[[nodiscard]] Status take_materials(const ObjectSource& source, LoadedCloud& loaded, MaterialFiles& kept,
                                    std::vector<Material>& materials, std::vector<std::uint32_t>& material_of,
                                    std::vector<TextureCorners>& texture_corners);

/// The MTL files that an OBJ file names, and the textures that these do, as far as they can be read.
[[nodiscard]] std::vector<std::string> files_of_obj_materials(const std::string& obj_path);

}  // namespace io
}  // namespace swept
