// Vertices and faces of OBJ files, with the colours that many write after x y z.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "splat/io/mesh_builder.h"
#include "splat/io/obj_materials.h"
#include "splat/io/obj_normals.h"

namespace swept {
namespace {

/// "7", "7/1", "7//3", "-1": the vertex of a face's corner.
Result<std::uint32_t> obj_corner(const MeshBuilder& mesh, std::string_view token) {
  const std::string_view number = token.substr(0, token.find('/'));
  if (!parse_integer(number)) return mesh.fail("face", not_a_number(token));
  return obj_index(mesh, number, mesh.vertex_count(), "vertex");
}

/// Places on a texture: lines vt, and which of them faces name.
class ObjTexture {
 public:
  Status add_place(MeshBuilder& mesh) {
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();
    for (int c = 0; c < 2; ++c) {
      const std::string_view token = mesh.lines.next_token();
      // One number is a place on a texture of one row.
      if (c == 1 && token.empty()) break;
      const std::optional<double> value = parse_number(token);
      if (!value) return mesh.fail("vt", not_a_number(token));
      if (!(std::abs(*value) <= double{most_texture_coordinate}))
        return mesh.fail("vt", "must be between -1e6 and 1e6");
      uv[c] = static_cast<float>(*value);
    }
    places_.push_back(uv);
    return Done{};
  }

  /// The second number of a corner. Where it has none that is an error, or else its face is not on the
  /// texture.
  Status add_corner(const MeshBuilder& mesh, std::string_view token, bool needed) {
    const std::size_t slash = token.find('/');
    const std::string_view rest = slash == std::string_view::npos ? "" : token.substr(slash + 1);
    const std::string_view number = rest.substr(0, rest.find('/'));
    if (number.empty() && !needed) {
      polygon_.push_back(no_place);
      return Done{};
    }
    if (number.empty())
      return mesh.fail("face", "its corner " + std::string(token) + " has no place on the texture");
    const Result<std::uint32_t> index = obj_index(mesh, number, places_.size(), "vt");
    if (!index) return index.error();
    polygon_.push_back(*index);
    greatest_ = std::max(greatest_, *index);
    any_ = true;
    return Done{};
  }

  [[nodiscard]] std::size_t places() const { return places_.size(); }

  /// `triangles` of the mesh are this face's and those before it.
  void end_face(std::size_t triangles) {
    if (std::find(polygon_.begin(), polygon_.end(), no_place) != polygon_.end()) {
      corners_.resize(triangles, {no_place, no_place, no_place});
    } else {
      add_fan(polygon_, corners_);
    }
    polygon_.clear();
  }

  /// What the triangles' corners are, once all lines are read; and of which triangles all have a place.
  Status finish(const std::string& path, std::vector<TextureCorners>& corners,
                std::vector<std::uint8_t>& on_texture) const {
    if (any_ && greatest_ >= places_.size())
      return Error{path, "face",
                   "index " + std::to_string(std::uint64_t{greatest_} + 1) + " names none of the " +
                       std::to_string(places_.size()) + " vt"};
    corners.reserve(corners_.size());
    for (const auto& [a, b, c] : corners_) {
      const bool on = a != no_place;
      on_texture.push_back(on ? 1 : 0);
      corners.push_back(
          on ? TextureCorners{places_[a], places_[b], places_[c]}
             : TextureCorners{Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero()});
    }
    return Done{};
  }

 private:
  static constexpr std::uint32_t no_place = std::numeric_limits<std::uint32_t>::max();

  std::vector<Eigen::Vector2f> places_;
  std::vector<std::uint32_t> polygon_;
  std::vector<std::array<std::uint32_t, 3>> corners_;
  std::uint32_t greatest_ = 0;
  bool any_ = false;  ///< corner has a place
};

/// What the numbers after x y z of a vertex are; others than a weight and colours are left unread.
std::vector<std::string> further_names(const MeshBuilder& mesh, std::vector<std::string>& unread,
                                       std::vector<std::string>& assumed) {
  const auto count = mesh.further_numbers();
  if (!count) {
    unread.push_back("numbers after x y z, which not all vertices have as many of");
    return {};
  }
  if (*count == 3) return {"red", "green", "blue"};
  if (*count == 4) {
    assumed.push_back("numbers 4 to 7 of the vertices are red, green, blue and alpha");
    return {"red", "green", "blue", "alpha"};
  }
  for (std::size_t k = 0; k < *count; ++k)
    unread.push_back(*count == 1 ? "w of the vertices"
                                 : "number " + std::to_string(k + 4) + " of the vertices");
  return {};
}

/// The normals of points without faces, one a point and in their order.
Status add_normals(std::string_view bytes, MeshBuilder& mesh) {
  std::array<std::vector<double>, 3> normals;
  LineScanner lines(bytes, "", '\\');
  while (lines.next_line()) {
    if (lines.next_token() != "vn") continue;
    for (std::vector<double>& axis : normals) {
      const std::string_view token = lines.next_token();
      const std::optional<double> value = parse_number(token);
      if (!value)
        return Error{"", "line " + std::to_string(lines.line_number()) + ", vn", not_a_number(token)};
      axis.push_back(*value);
    }
  }
  mesh.add_column("nx", std::move(normals[0]));
  mesh.add_column("ny", std::move(normals[1]));
  mesh.add_column("nz", std::move(normals[2]));
  return Done{};
}

}  // namespace

Result<PointSet> read_obj(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  MeshBuilder mesh(path, LineScanner(bytes, "", '\\'));
  ObjTexture texture;
  ObjNormals normals;
  ObjMaterialNames materials;
  const bool places = options.texture || options.materials;
  std::vector<std::uint32_t> polygon;
  std::uint32_t greatest = 0;
  std::map<std::string, std::size_t> others;  // keywords that are not read
  while (mesh.lines.next_line()) {
    const std::string_view keyword = mesh.lines.next_token();
    if (keyword == "v") {
      if (Status s = mesh.add_vertex(mesh.lines.next_token()); !s) return s.error();
    } else if (keyword == "f") {
      polygon.clear();
      for (auto token = mesh.lines.next_token(); !token.empty(); token = mesh.lines.next_token()) {
        const Result<std::uint32_t> corner = obj_corner(mesh, token);
        if (!corner) return corner.error();
        polygon.push_back(*corner);
        greatest = std::max(greatest, *corner);
        if (options.corner_normals)
          if (Status s = normals.add_corner(mesh, *corner, token); !s) return s.error();
        if (!places) continue;
        if (Status s = texture.add_corner(mesh, token, options.texture); !s) return s.error();
      }
      add_fan(polygon, mesh.triangles);
      if (options.split_normals) normals.end_face();
      if (places) texture.end_face(mesh.triangles.size());
      if (options.materials) materials.end_face(mesh.triangles.size());
    } else if (keyword == "vt" && places) {
      if (Status s = texture.add_place(mesh); !s) return s.error();
    } else if (keyword == "mtllib" && options.materials) {
      materials.add_files(mesh.lines);
    } else if (keyword == "usemtl" && options.materials) {
      materials.use(mesh.lines);
    } else if (keyword == "vn" && options.corner_normals) {
      if (Status s = normals.add(mesh); !s) return s.error();
    } else if (const auto known = others.find(std::string(keyword)); known != others.end()) {
      ++known->second;
    } else if (others.size() < 100) {
      others.emplace(keyword, 1);
    }
  }
  if (!mesh.triangles.empty() && greatest >= mesh.vertex_count()) {
    return Error{path, "face",
                 "index " + std::to_string(std::uint64_t{greatest} + 1) + " names none of the " +
                     std::to_string(mesh.vertex_count()) + " vertices"};
  }
  const std::size_t libraries = materials.libraries();
  MaterialNames names = materials.finish();
  if (names.names.empty()) {
    if (libraries > 0) others.emplace("mtllib", libraries);
    if (!options.texture && texture.places() > 0) others.emplace("vt", texture.places());
  }
  if (Status s = texture.finish(path, mesh.texture_corners, names.on_texture); !s) return s.error();
  std::vector<std::string> unread, assumed;
  const std::vector<std::string> further = further_names(mesh, unread, assumed);
  if (Status s = normals.finish(path, mesh, assumed); !s) return s.error();
  if (normals.unread() > 0) others.emplace("vn", normals.unread());
  if (const auto lines = others.find("vn");
      mesh.triangles.empty() && lines != others.end() && lines->second == mesh.vertex_count()) {
    if (const Status s = add_normals(bytes, mesh); !s)
      return Error{path, s.error().field, s.error().reason, in_a_file(s.error().kind)};
    assumed.push_back("there is a vn for each v, and no face: they are the points' normals");
    others.erase(lines);
  }
  // No header says so: the file may as well have been cut off.
  if (mesh.vertex_count() == 0) return Error{path, "", "has no points"};
  Result<PointSet> set = mesh.finish(further, options);
  if (!set) return set;
  // Triangles have gone with points.
  if (options.split_normals && set->report.dropped == 0) set->corner_normals = normals.by_corner();
  if (names.names.empty()) {
    if (!options.texture) set->texture_corners.clear();
  } else if (set->report.dropped > 0) {
    if (!options.texture) set->texture_corners.clear();
    assumed.push_back("materials are not used, as points are left out");
  } else {
    set->materials = std::move(names);
    set->report.used.push_back({"materials", {"usemtl"}});
  }
  if (!set->texture_corners.empty()) set->report.used.push_back({"texture coordinates", {"vt"}});
  for (const auto& [keyword, count] : others)
    unread.push_back(std::to_string(count) + (count == 1 ? " line " : " lines ") + keyword);
  set->report.unread.insert(set->report.unread.end(), unread.begin(), unread.end());
  set->report.assumed.insert(set->report.assumed.end(), assumed.begin(), assumed.end());
  return set;
}

}  // namespace swept
