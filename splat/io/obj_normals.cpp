#include "splat/io/obj_normals.h"

#include <limits>
#include <utility>

namespace swept {

Result<std::uint32_t> obj_index(const MeshBuilder& mesh, std::string_view number, std::size_t have,
                                const char* what) {
  const auto index = parse_integer(number);
  if (!index) return mesh.fail("face", not_a_number(number));
  const std::int64_t from_0 = *index < 0 ? static_cast<std::int64_t>(have) + *index : *index - 1;
  if (from_0 < 0 || from_0 >= std::numeric_limits<std::uint32_t>::max())
    return mesh.fail("face", "index " + std::to_string(*index) + " names no " + what);
  return static_cast<std::uint32_t>(from_0);
}

Status ObjNormals::add(MeshBuilder& mesh) {
  Eigen::Vector3d normal;
  for (int c = 0; c < 3; ++c) {
    const std::string_view token = mesh.lines.next_token();
    const std::optional<double> value = parse_number(token);
    if (!value) return mesh.fail("vn", not_a_number(token));
    normal[c] = *value;
  }
  normals_.push_back(normal.allFinite() ? Eigen::Vector3d(normal.stableNormalized()) : normal);
  return Done{};
}

Status ObjNormals::add_corner(const MeshBuilder& mesh, std::uint32_t vertex, std::string_view token) {
  const std::size_t first = token.find('/');
  const std::size_t second = first == std::string_view::npos ? first : token.find('/', first + 1);
  polygon_.push_back(no_normal);
  if (second == std::string_view::npos) return Done{};
  const Result<std::uint32_t> index = obj_index(mesh, token.substr(second + 1), normals_.size(), "vn");
  if (!index) return index.error();
  corners_.push_back({vertex, *index});
  polygon_.back() = *index;
  return Done{};
}

void ObjNormals::end_face() {
  add_fan(polygon_, by_triangle_);
  polygon_.clear();
}

std::vector<CornerNormals> ObjNormals::by_corner() const {
  std::vector<CornerNormals> normals;
  if (corners_.empty() || normals_.empty()) return normals;
  normals.reserve(by_triangle_.size());
  for (const auto& corners : by_triangle_) {
    CornerNormals& of_triangle = normals.emplace_back();
    for (std::size_t c = 0; c < 3; ++c)
      of_triangle[c] = corners[c] < normals_.size() ? Eigen::Vector3f(normals_[corners[c]].cast<float>())
                                                    : Eigen::Vector3f(Eigen::Vector3f::Zero());
  }
  return normals;
}

Status ObjNormals::finish(const std::string& path, MeshBuilder& mesh,
                          std::vector<std::string>& assumed) const {
  if (corners_.empty()) return Done{};
  if (normals_.empty()) {
    assumed.push_back("corners of faces name vn, and the file has none");
    return Done{};
  }
  const std::size_t count = mesh.vertex_count();
  std::vector<Eigen::Vector3d> normal(count, Eigen::Vector3d::Zero());
  enum : char { none, one, several };
  std::vector<char> found(count, none);
  std::size_t hard = 0;
  for (const auto& [vertex, index] : corners_) {
    if (vertex >= count) continue;  // of a face without an area
    if (index >= normals_.size())
      return Error{path, "face",
                   "index " + std::to_string(std::uint64_t{index} + 1) + " names none of the " +
                       std::to_string(normals_.size()) + " vn"};
    if (found[vertex] == none) {
      found[vertex] = one;
      normal[vertex] = normals_[index];
    } else if (constexpr double same = 1e-3;  // digits of files differ
               found[vertex] == one && !((normal[vertex] - normals_[index]).norm() <= same)) {
      found[vertex] = several;
      normal[vertex].setZero();
      ++hard;
    }
  }
  for (int c = 0; c < 3; ++c) {
    std::vector<double> column;
    column.reserve(count);
    for (const Eigen::Vector3d& n : normal) column.push_back(n[c]);
    mesh.add_column(std::string("n") + "xyz"[c], std::move(column));
  }
  if (hard > 0)
    assumed.push_back(std::to_string(hard) +
                      " vertices have several vn, as at hard edges: their normals are those of all their "
                      "triangles");
  return Done{};
}

}  // namespace swept
