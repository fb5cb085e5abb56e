// Vertices and faces of OFF files, with the normals and colours of NOFF and COFF.
#include <algorithm>
#include <array>

#include "splat/io/mesh_builder.h"

namespace swept {
namespace {

struct Kind {
  const char* keyword;
  bool normals, colors;
};
constexpr std::array<Kind, 4> kinds{
    {{"CNOFF", true, true}, {"COFF", false, true}, {"NOFF", true, false}, {"OFF", false, false}}};

/// What the numbers after x y z of a vertex are, by the header and by how many there are.
std::vector<std::string> further_names(const MeshBuilder& mesh, const Kind& kind,
                                       std::vector<std::string>& unread, std::vector<std::string>& assumed) {
  const auto count = mesh.further_numbers();
  if (!count) {
    unread.push_back("numbers after x y z, which not all vertices have as many of");
    return {};
  }
  std::vector<std::string> names;
  if (kind.normals && *count >= 3) names = {"nx", "ny", "nz"};
  const std::size_t left = *count - names.size();
  if (left == 3 || left == 4) {
    names.insert(names.end(), {"red", "green", "blue"});
    if (left == 4) names.push_back("alpha");
    if (!kind.colors)
      assumed.push_back("the last " + std::to_string(left) +
                        " numbers of each vertex are colours, though the "
                        "header does not say so");
    return names;
  }
  while (names.size() < *count) {
    unread.push_back("number " + std::to_string(names.size() + 4) + " of the vertices");
    names.emplace_back();
  }
  return names;
}

/// Faces may hold a colour after their corners.
Status read_faces(MeshBuilder& mesh, const std::string& path, std::int64_t vertices, std::int64_t faces,
                  std::size_t& colored) {
  std::vector<std::uint32_t> polygon;
  for (std::int64_t f = 0; f < faces; ++f) {
    if (!mesh.lines.next_line()) {
      return Error{path, "face",
                   "the header promises " + std::to_string(faces) + ", the file has " + std::to_string(f)};
    }
    const auto corners = parse_integer(mesh.lines.next_token());
    if (!corners || *corners < 0) return mesh.fail("face", "does not start with its number of corners");
    polygon.clear();
    for (std::int64_t c = 0; c < *corners; ++c) {
      const auto index = parse_integer(mesh.lines.next_token());
      if (!index) return mesh.fail("face", "has fewer than " + std::to_string(*corners) + " indices");
      if (*index < 0 || *index >= vertices) {
        return mesh.fail("face", "index " + std::to_string(*index) + " names none of the " +
                                     std::to_string(vertices) + " vertices");
      }
      polygon.push_back(static_cast<std::uint32_t>(*index));
    }
    colored += !mesh.lines.next_token().empty();
    add_fan(polygon, mesh.triangles);
  }
  return Done{};
}

}  // namespace

Result<PointSet> read_off(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  MeshBuilder mesh(path, LineScanner(bytes));
  LineScanner& lines = mesh.lines;
  std::string_view token = lines.next_line() ? lines.next_token() : "";
  const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& k) {
    return token.substr(0, std::string_view(k.keyword).size()) == k.keyword;
  });
  const std::string_view glued =
      kind == kinds.end() ? "" : token.substr(std::string_view(kind->keyword).size());
  // "OFF4 2 0": some leave the blank out.
  if (kind == kinds.end() || (!glued.empty() && !parse_integer(glued))) {
    return Error{path, "header", "does not start with OFF, COFF, NOFF or CNOFF"};
  }
  token = glued.empty() ? lines.next_token() : glued;
  if (token == "BINARY") return Error{path, "header", "binary OFF is not supported", ErrorKind::unsupported};
  if (token.empty() && lines.next_line()) token = lines.next_token();
  const auto vertices = parse_integer(token), faces = parse_integer(lines.next_token());
  if (!vertices || !faces || *vertices < 0 || *faces < 0) {
    return mesh.fail("header", "needs the numbers of vertices and faces");
  }
  for (std::int64_t v = 0; v < *vertices; ++v) {
    if (!lines.next_line()) {
      return Error{
          path, "vertex",
          "the header promises " + std::to_string(*vertices) + ", the file has " + std::to_string(v)};
    }
    if (Status s = mesh.add_vertex(lines.next_token()); !s) return s.error();
  }
  std::size_t colored = 0, after = 0;
  if (Status s = read_faces(mesh, path, *vertices, *faces, colored); !s) return s.error();
  while (lines.next_line()) ++after;

  std::vector<std::string> unread, assumed;
  const std::vector<std::string> further = further_names(mesh, *kind, unread, assumed);
  Result<PointSet> set = mesh.finish(further, options);
  if (!set) return set;
  if (colored > 0) unread.push_back("colours of " + std::to_string(colored) + " faces");
  if (after > 0) unread.push_back(std::to_string(after) + " lines after the last face");
  set->report.unread.insert(set->report.unread.end(), unread.begin(), unread.end());
  set->report.assumed.insert(set->report.assumed.end(), assumed.begin(), assumed.end());
  return set;
}

}  // namespace swept
