#include "abuffer/sources/placed_triangle.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "splat/motion/look.h"

namespace swept {
namespace {

/// What depends linearly on the viewing ray.
Linear on_film(const Eigen::Vector3d& v, const Projection& projection) {
  const double a = v.x() / projection.focal_px, b = v.y() / projection.focal_px;
  return {a, b, v.z() - (a * projection.center_x + b * projection.center_y)};
}

}  // namespace

std::optional<PlacedTriangle> place_triangle(const MeshInstant& mesh, std::size_t triangle) {
  const Object& object = mesh.object();
  const bool orthographic = mesh.projection().orthographic;
  const Eigen::Vector3d *corner[3], *const *p = corner;
  for (std::size_t i = 0; i < 3; ++i) corner[i] = &mesh.corner(triangle, i);
  const double z[3] = {p[0]->z(), p[1]->z(), p[2]->z()};
  // Parallel rays see of it what those from an eye do of its shadow at depth 1.
  Eigen::Vector3d shadow[3];
  for (std::size_t i = 0; orthographic && i < 3; ++i) {
    shadow[i] = {p[i]->x(), p[i]->y(), 1.0};
    corner[i] = &shadow[i];
  }
  const Eigen::Vector3d normals[3] = {p[1]->cross(*p[2]), p[2]->cross(*p[0]), p[0]->cross(*p[1])};
  const double volume = p[0]->dot(normals[0]);
  if (!(std::abs(volume) > 0.0) || !std::isfinite(volume)) return std::nullopt;
  // Counter-clockwise from the front: n·p < 0 there.
  if (!object.two_sided && (volume < 0.0) == mesh.mirrored()) return std::nullopt;
  PlacedTriangle placed;
  const double side = volume > 0.0 ? 1.0 : -1.0;
  double weight[3];
  for (std::size_t i = 0; i < 3; ++i) {
    Linear& edge = placed.edge[i];
    edge = on_film(normals[i], mesh.projection());
    const double scale = std::abs(edge.a) + std::abs(edge.b);
    weight[i] = scale > 0.0 ? scale : 1.0;
    edge = {side * edge.a / weight[i], side * edge.b / weight[i], side * edge.c / weight[i]};
    placed.owns[i] = edge.a > 0.0 || (edge.a == 0.0 && edge.b > 0.0);
  }
  const double heaviest = std::max({weight[0], weight[1], weight[2]});
  for (std::size_t i = 0; i < 3; ++i) placed.weight[i] = static_cast<float>(weight[i] / heaviest);
  if (orthographic) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i) sum += (mesh.behind() - z[i]) / volume * normals[i];
    placed.inverse_depth = on_film(sum, mesh.projection());
    placed.most_inverse = static_cast<float>(mesh.behind() - mesh.near());
  } else {
    const Eigen::Vector3d sum = (normals[0] + normals[1] + normals[2]) / volume;
    placed.inverse_depth = on_film(sum, mesh.projection());
    placed.most_inverse = static_cast<float>(1.0 / mesh.near());
  }
  placed.cut = !(z[0] >= mesh.near() && z[1] >= mesh.near() && z[2] >= mesh.near());
  placed.plain = true;
  const LooksAt looks(object.cloud, mesh.frame());
  const Eigen::Vector4f tint = object.tint_of(triangle);
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector4f rgba = looks[object.triangles[triangle][i]].cwiseProduct(tint);
    for (int c = 0; c < 4; ++c) placed.rgba[i][c] = rgba[c];
    placed.plain = placed.plain && std::equal(placed.rgba[i], placed.rgba[i] + 4, placed.rgba[0]);
  }
  placed.texture = object.texture_of(triangle);
  placed.textured = placed.texture != nullptr;
  if (placed.textured) {
    const TextureCorners& corners = object.texture_corners[triangle];
    // The picture repeats: near zero there are more digits.
    const Eigen::Vector2f whole = corners[0].array().floor();
    for (std::size_t i = 0; i < 3; ++i)
      for (int c = 0; c < 2; ++c) placed.uv[i][c] = corners[i][c] - whole[c];
  }
  return placed;
}

}  // namespace swept
