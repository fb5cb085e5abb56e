// Vertices and faces of OBJ files, with the colours that many write after x y z.
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <utility>

#include "splat/io/mesh_builder.h"

namespace swept {
namespace {

/// "7", "7/1", "7//3", "-1": corner of an OBJ face, from 0. Vertices may still follow the face.
Result<std::uint32_t> obj_corner(const MeshBuilder& mesh, std::string_view token) {
  const auto index = parse_integer(token.substr(0, token.find('/')));
  if (!index) return mesh.fail("face", not_a_number(token));
  const auto have = static_cast<std::int64_t>(mesh.vertex_count());
  const std::int64_t from_0 = *index < 0 ? have + *index : *index - 1;
  if (from_0 < 0 || from_0 >= std::numeric_limits<std::uint32_t>::max()) {
    return mesh.fail("face", "index " + std::to_string(*index) + " names no vertex");
  }
  return static_cast<std::uint32_t>(from_0);
}

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
      }
      add_fan(polygon, mesh.triangles);
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
  std::vector<std::string> unread, assumed;
  const std::vector<std::string> further = further_names(mesh, unread, assumed);
  if (const auto normals = others.find("vn");
      mesh.triangles.empty() && normals != others.end() && normals->second == mesh.vertex_count()) {
    if (const Status s = add_normals(bytes, mesh); !s)
      return Error{path, s.error().field, s.error().reason, in_a_file(s.error().kind)};
    assumed.push_back("there is a vn for each v, and no face: they are the points' normals");
    others.erase(normals);
  }
  Result<PointSet> set = mesh.finish(further, options);
  if (!set) return set;
  for (const auto& [keyword, count] : others)
    unread.push_back(std::to_string(count) + (count == 1 ? " line " : " lines ") + keyword);
  set->report.unread.insert(set->report.unread.end(), unread.begin(), unread.end());
  set->report.assumed.insert(set->report.assumed.end(), assumed.begin(), assumed.end());
  return set;
}

}  // namespace swept
