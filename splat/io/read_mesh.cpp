// Vertices and faces of OBJ and OFF files. Written here rather than taken from OpenMesh: its readers round
// positions to float, leave out vertices they cannot read (which renumbers the rest), drop faces that
// are not manifold, believe the header's counts, and print.
#include <charconv>
#include <limits>

#include "splat/io/attributes.h"
#include "splat/io/file_bytes.h"
#include "splat/io/read_formats.h"

namespace swept {
namespace {

/// A mesh in the making, and where in its file we are.
class MeshBuilder {
 public:
  MeshBuilder(const std::string& path, std::string_view bytes) : lines(bytes), path_(path) {}

  LineScanner lines;
  std::vector<Triangle> triangles;

  /// The next three tokens as a vertex.
  Status add_vertex(std::string_view x) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::string_view token = c == 0 ? x : lines.next_token();
      const std::optional<double> value = parse_number(token);
      if (!value) {
        const std::string reason =
            token.empty() ? "the vertex has fewer than three numbers" : not_a_number(token);
        return fail(columns()[c].name, reason);
      }
      values_[c].push_back(*value);
    }
    return Done{};
  }

  [[nodiscard]] std::size_t vertex_count() const { return values_[0].size(); }

  [[nodiscard]] Error fail(const std::string& what, const std::string& reason) const {
    return {path_, "line " + std::to_string(lines.line_number()) + ", " + what, reason};
  }

  Result<PointSet> finish(const ReadOptions& options) {
    const Result<AttributePlan> plan = plan_attributes(path_, columns(), options);
    if (!plan) return plan.error();
    return assemble_points(path_, columns(), *plan, values_, std::move(triangles), options);
  }

 private:
  static const std::vector<Column>& columns() {
    static const std::vector<Column> xyz{{"x"}, {"y"}, {"z"}};
    return xyz;
  }

  const std::string& path_;
  std::vector<std::vector<double>> values_ = std::vector<std::vector<double>>(3);
};

std::optional<std::int64_t> parse_integer(std::string_view token) {
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (code != std::errc{} || end != token.data() + token.size()) return std::nullopt;
  return value;
}

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

}  // namespace

Result<PointSet> read_obj(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  MeshBuilder mesh(path, bytes);
  std::vector<std::uint32_t> polygon;
  std::uint32_t greatest = 0;
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
    }
  }
  if (!mesh.triangles.empty() && greatest >= mesh.vertex_count()) {
    return Error{path, "face",
                 "index " + std::to_string(std::uint64_t{greatest} + 1) + " names none of the " +
                     std::to_string(mesh.vertex_count()) + " vertices"};
  }
  return mesh.finish(options);
}

Result<PointSet> read_off(const std::string& path, std::string_view bytes, const ReadOptions& options) {
  MeshBuilder mesh(path, bytes);
  LineScanner& lines = mesh.lines;
  const std::string_view keyword = lines.next_line() ? lines.next_token() : "";
  if (keyword != "OFF" && keyword != "COFF" && keyword != "NOFF" && keyword != "CNOFF") {
    return Error{path, "header", "does not start with OFF, COFF, NOFF or CNOFF"};
  }
  std::string_view token = lines.next_token();
  if (token == "BINARY") return Error{path, "header", "binary OFF is not supported"};
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
  std::vector<std::uint32_t> polygon;
  for (std::int64_t f = 0; f < *faces; ++f) {
    if (!lines.next_line()) {
      return Error{path, "face",
                   "the header promises " + std::to_string(*faces) + ", the file has " + std::to_string(f)};
    }
    const auto corners = parse_integer(lines.next_token());
    if (!corners || *corners < 0) return mesh.fail("face", "does not start with its number of corners");
    polygon.clear();
    for (std::int64_t c = 0; c < *corners; ++c) {
      const auto index = parse_integer(lines.next_token());
      if (!index) return mesh.fail("face", "has fewer than " + std::to_string(*corners) + " indices");
      if (*index < 0 || *index >= *vertices) {
        return mesh.fail("face", "index " + std::to_string(*index) + " names none of the " +
                                     std::to_string(*vertices) + " vertices");
      }
      polygon.push_back(static_cast<std::uint32_t>(*index));
    }
    add_fan(polygon, mesh.triangles);
  }
  return mesh.finish(options);
}

}  // namespace swept
