// Lines vn of OBJ files, and which of them the corners of faces name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "splat/io/mesh_builder.h"

namespace swept {

/// An index of a face's corner from 0, where there are `have` of `what` it names so far. More may still
/// follow the face.
[[nodiscard]] Result<std::uint32_t> obj_index(const MeshBuilder& mesh, std::string_view number,
                                              std::size_t have, const char* what);

class ObjNormals {
 public:
  /// The rest of a line vn.
  [[nodiscard]] Status add(MeshBuilder& mesh);
  /// The third number of a corner, "7/1/3" or "7//3", if it has one.
  [[nodiscard]] Status add_corner(const MeshBuilder& mesh, std::uint32_t vertex, std::string_view token);
  /// How many lines there are, if no corner names any.
  [[nodiscard]] std::size_t unread() const { return corners_.empty() ? normals_.size() : 0; }
  /// Gives the vertices columns nx, ny, nz where any corner has a normal: the one that all corners of a
  /// vertex agree on, else zero.
  [[nodiscard]] Status finish(const std::string& path, MeshBuilder& mesh,
                              std::vector<std::string>& assumed) const;

 private:
  struct Corner {
    std::uint32_t vertex, normal;
  };
  std::vector<Eigen::Vector3d> normals_;
  std::vector<Corner> corners_;
};

}  // namespace swept
