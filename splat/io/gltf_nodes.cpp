#include <algorithm>
#include <cmath>

#include "splat/io/gltf_file.h"

namespace swept::io {
namespace {

constexpr std::size_t most_nodes = std::size_t{1} << 18;

GltfNode node_of(const JsonNode& json) {
  GltfNode node;
  const auto rotation = json.find("rotation"), matrix = json.find("matrix");
  if (const auto translation = json.find("translation")) node.translation = translation->vector3();
  if (const auto scale = json.find("scale")) node.scale = scale->vector3();
  if (rotation) {
    const std::vector<double> q = rotation->numbers(4);  // x y z w
    const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
    if (!(turn.coeffs().stableNorm() > 0.0)) rotation->fail("is a quaternion of length zero");
    node.rotation.coeffs() = turn.coeffs().stableNormalized();
  }
  if (matrix) {
    if (rotation || json.find("translation") || json.find("scale"))
      matrix->fail("stands beside a translation, rotation or scale");
    const std::vector<double> columns = matrix->numbers(16);
    node.matrix = Eigen::Map<const Eigen::Matrix4d>(columns.data());
    if (node.matrix->row(3) != Eigen::RowVector4d(0, 0, 0, 1)) matrix->fail("is no affine transform");
  }
  return node;
}

}  // namespace

Eigen::Matrix4d GltfNode::local() const {
  if (matrix) return *matrix;
  Eigen::Affine3d local = Eigen::Translation3d(translation) * rotation;
  local.linear() *= scale.asDiagonal();
  return local.matrix();
}

std::vector<GltfNode> GltfFile::nodes() const {
  std::vector<GltfNode> nodes;
  const std::optional<JsonNode> all = root().find("nodes");
  if (!all) return nodes;
  const std::vector<JsonNode> elements = all->elements();
  if (elements.size() > most_nodes) all->fail("has more than " + std::to_string(most_nodes) + " nodes");
  for (const JsonNode& element : elements) nodes.push_back(node_of(element));
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const auto children = elements[i].find("children");
    if (!children) continue;
    for (const JsonNode& child : children->elements()) {
      std::optional<std::size_t>& parent = nodes[index_in("nodes", child)].parent;
      if (parent) child.fail("already has a parent, node " + std::to_string(*parent));
      parent = i;
    }
  }
  // Every node has one parent at most, so whoever walks up from one and never arrives goes in a circle.
  enum class Seen : char { never, on_this_walk, before };
  std::vector<Seen> seen(nodes.size(), Seen::never);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    std::optional<std::size_t> at = i;
    for (; at && seen[*at] == Seen::never; at = nodes[*at].parent) seen[*at] = Seen::on_this_walk;
    if (at && seen[*at] == Seen::on_this_walk) elements[*at].fail("is its own ancestor");
    for (at = i; at && seen[*at] == Seen::on_this_walk; at = nodes[*at].parent) seen[*at] = Seen::before;
  }
  return nodes;
}

std::vector<std::size_t> GltfFile::nodes_in_scene() const {
  const std::vector<GltfNode> all = nodes();
  std::vector<std::size_t> found;
  const std::optional<JsonNode> scenes = root().find("scenes"), chosen = root().find("scene");
  if (!scenes) {
    for (std::size_t i = 0; i < all.size(); ++i) found.push_back(i);
    return found;
  }
  const std::vector<JsonNode> scene_elements = scenes->elements();
  if (!chosen && scene_elements.empty()) scenes->fail("must not be empty");
  std::vector<bool> is_in(all.size(), false);
  const JsonNode scene = chosen ? element("scenes", *chosen) : scene_elements.front();
  if (const auto roots = scene.find("nodes"))
    for (const JsonNode& index : roots->elements()) is_in[index_in("nodes", index)] = true;
  std::vector<std::size_t> path;
  std::vector<bool> done(all.size(), false);
  for (std::size_t i = 0; i < all.size(); ++i) {
    path.clear();
    std::optional<std::size_t> at = i;
    for (; at && !done[*at] && !is_in[*at]; at = all[*at].parent) path.push_back(*at);
    const bool in = at && is_in[*at];
    for (const std::size_t node : path) {
      is_in[node] = in;
      done[node] = true;
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    if (is_in[i]) found.push_back(i);
  return found;
}

std::vector<Eigen::Matrix4d> scene_from_nodes(const std::vector<GltfNode>& nodes) {
  std::vector<Eigen::Matrix4d> transforms(nodes.size());
  std::vector<bool> done(nodes.size(), false);
  std::vector<std::size_t> path;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    path.clear();
    for (std::optional<std::size_t> at = i; at && !done[*at]; at = nodes[*at].parent) path.push_back(*at);
    for (; !path.empty(); path.pop_back()) {
      const GltfNode& node = nodes[path.back()];
      transforms[path.back()] =
          node.parent ? Eigen::Matrix4d(transforms[*node.parent] * node.local()) : node.local();
      done[path.back()] = true;
    }
  }
  return transforms;
}

}  // namespace swept::io
