// A glTF 2.0 file: its document, its nodes, and the numbers of its accessors. Private to splat/io.
//
// Source: the specification of glTF 2.0, Khronos Group. Nothing is decoded that nobody asks for: images,
// compressed meshes and unknown extensions are no hindrance to whom they do not concern. As with JsonNode,
// every refusal throws a swept::Error with the file, a JSON pointer and the reason.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "splat/io/json_node.h"

namespace swept::io {

/// The elements of an accessor. Refers to the file's buffers and must not outlive them.
class GltfAccessor {
 public:
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t components() const { return components_; }  ///< 16 of MAT4, column by column
  [[nodiscard]] bool is_float() const { return type_ == 5126; }
  [[nodiscard]] bool is_normalized() const { return normalized_; }
  /// Normalised integers in [0, 1] or [-1, 1]. Precondition: element < count(), component < components().
  [[nodiscard]] double number(std::size_t element, std::size_t component) const;

 private:
  friend class GltfFile;
  const char* data_ = nullptr;
  std::shared_ptr<const std::string> own_;  ///< what data_ points to where the file has no such bytes
  std::size_t count_ = 0, components_ = 1, stride_ = 0;
  int type_ = 0;
  bool normalized_ = false;
};

struct GltfNode {
  std::optional<std::size_t> parent;
  /// Of nodes without a matrix.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero(), scale = Eigen::Vector3d::Ones();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit length
  std::optional<Eigen::Matrix4d> matrix;

  /// The parent's space from the node's.
  [[nodiscard]] Eigen::Matrix4d local() const;
};

class GltfFile {
 public:
  /// Of .glb and of .gltf, which is told from the bytes. The folder of `path` is where other files are looked
  /// for. `bytes` have to stay.
  GltfFile(const std::string& path, std::string_view bytes);
  explicit GltfFile(const std::string& path);

  [[nodiscard]] const std::string& path() const { return *path_; }
  [[nodiscard]] JsonNode root() const { return {*document_, *path_}; }
  /// The element of the root's array that `index` names; `index` is refused where there is none.
  [[nodiscard]] JsonNode element(const std::string& array, const JsonNode& index) const;
  /// What `index` names, checked against the root's array; for comparing and for nodes().
  [[nodiscard]] std::size_t index_in(const std::string& array, const JsonNode& index) const;

  /// The accessor that `index` names, of this type: "SCALAR", "VEC3", "MAT4", …. All its bytes are there.
  [[nodiscard]] GltfAccessor accessor(const JsonNode& index, std::string_view type) const;

  /// All nodes, refused where one has two parents or is its own ancestor, or there are more than 2^18.
  [[nodiscard]] std::vector<GltfNode> nodes() const;
  /// The nodes of the default scene and all below them; all nodes of a file without scenes.
  [[nodiscard]] std::vector<std::size_t> nodes_in_scene() const;

  /// How many bytes of buffers have been read; those that several share count once.
  [[nodiscard]] std::size_t buffer_bytes() const;

 private:
  /// The file's own, or bytes that were unpacked or read for it.
  struct Buffer {
    std::string_view bytes;
    std::shared_ptr<const std::string> own;
  };

  void read_document(std::string_view bytes);
  [[nodiscard]] std::string_view buffer(const JsonNode& index) const;
  [[nodiscard]] Buffer read_buffer(const JsonNode& uri) const;
  [[nodiscard]] std::string_view view(const JsonNode& index, std::size_t& stride) const;
  void add_sparse(const JsonNode& sparse, std::size_t element_bytes, GltfAccessor& accessor) const;

  std::unique_ptr<const std::string> path_;     ///< nodes refer to it
  std::unique_ptr<const std::string> content_;  ///< of a file that was read here
  std::unique_ptr<const nlohmann::json> document_;
  std::optional<std::string_view> chunk_;          ///< the buffer in a .glb
  mutable std::map<std::size_t, Buffer> buffers_;  ///< those that were asked for
  mutable std::map<std::string, Buffer> files_;    ///< several buffers may be in one file
};

/// The axes that splats are trained in, right, down and forward, from those of glTF, left, up and forward.
[[nodiscard]] inline Eigen::Matrix4d training_from_gltf() {
  return Eigen::Vector4d(-1.0, -1.0, 1.0, 1.0).asDiagonal();
}

/// The scene's space from that of each node. Precondition: as GltfFile::nodes() returns them.
[[nodiscard]] std::vector<Eigen::Matrix4d> scene_from_nodes(const std::vector<GltfNode>& nodes);

}  // namespace swept::io
