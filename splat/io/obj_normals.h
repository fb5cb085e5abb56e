// Lines vn of OBJ files, and which of them the corners of faces name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
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
  /// A face's corners are those added since the last one.
  void end_face();
  /// By triangle of the faces that were ended, if any corner of theirs has a normal, which finish() has found
  /// to be there.
  [[nodiscard]] std::vector<CornerNormals> by_corner() const;
  /// Gives the vertices columns nx, ny, nz where any corner has a normal: the one that all corners of a
  /// vertex agree on, else zero.
  [[nodiscard]] Status finish(const std::string& path, MeshBuilder& mesh,
                              std::vector<std::string>& assumed) const;

 private:
  struct Corner {
    std::uint32_t vertex, normal;
  };
  std::vector<Eigen::Vector3d> normals_;
  static constexpr std::uint32_t no_normal = std::numeric_limits<std::uint32_t>::max();

  std::vector<Corner> corners_;
  std::vector<std::uint32_t> polygon_;  ///< normals of the corners of the face that is read
  std::vector<std::array<std::uint32_t, 3>> by_triangle_;  ///< of ended faces
};

}  // namespace swept
