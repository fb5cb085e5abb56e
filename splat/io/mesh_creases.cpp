#include "splat/io/mesh_creases.h"

#include <numbers>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "splat/io/mesh_normals.h"

namespace swept::io {
namespace {

template <class Array>
void append_copies(const std::vector<std::uint32_t>& copies, Array& values) {
  if (values.empty()) return;
  for (const std::uint32_t i : copies) {
    const auto value = std::as_const(values)[i];
    values.push_back(value);
  }
}

void append_copies(const std::vector<std::uint32_t>& copies, SurfelCloud& cloud) {
  for (SurfelKey& key : cloud.keys) {
    append_copies(copies, key.pose.position);
    append_copies(copies, key.pose.axis_u);
    append_copies(copies, key.pose.axis_v);
  }
  for (LookKey& look : cloud.looks) {
    append_copies(copies, look.color);
    append_copies(copies, look.opacity);
  }
  append_copies(copies, cloud.velocity);
  append_copies(copies, cloud.acceleration);
  append_copies(copies, cloud.angular_velocity);
  append_copies(copies, cloud.lifetime);
  append_copies(copies, cloud.color);
  append_copies(copies, cloud.opacity);
  append_copies(copies, cloud.oriented);
}

/// Turns points `split` along the normals of their triangles at every key.
void turn_split(const std::vector<std::uint32_t>& split, const std::vector<Triangle>& about_them,
                SurfelCloud& cloud) {
  SurfelPose last;
  for (SurfelKey& key : cloud.keys) {
    const std::vector<Eigen::Vector3d> normals = mesh_normals(key.pose.position.own(), about_them);
    SurfelPose turned;
    for (const std::uint32_t i : split) {
      Eigen::Vector3f u = std::as_const(key.pose.axis_u)[i], v = std::as_const(key.pose.axis_v)[i];
      if (!normals[i].isZero(0.0)) round_disc(normals[i], static_cast<double>(u.stableNorm()), u, v);
      turned.position.push_back(std::as_const(key.pose.position)[i]);
      turned.axis_u.push_back(u);
      turned.axis_v.push_back(v);
    }
    if (last.size() > 0) align_axes(last, turned);
    for (std::size_t k = 0; k < split.size(); ++k) {
      key.pose.axis_u[split[k]] = turned.axis_u[k];
      key.pose.axis_v[split[k]] = turned.axis_v[k];
    }
    last = std::move(turned);
  }
}

void tell(const CreasedMesh& mesh, std::size_t points, ReadReport& report) {
  report.assumed.push_back(std::to_string(mesh.hard) + " of " + std::to_string(mesh.edges) +
                           " edges are hard, and " + std::to_string(mesh.boundary) +
                           " at the boundary: " + std::to_string(mesh.copies.size()) + " copies of " +
                           std::to_string(points) + " points");
  if (mesh.apart > 0)
    report.assumed.push_back(
        std::to_string(mesh.apart) +
        " triangles share an edge with two others, face against a neighbour or stand on the point of a "
        "surface: they are drawn, and their edges are hard");
}

}  // namespace

Status split_at_creases(const CloudSource& source, std::size_t reference, LoadedCloud& loaded) {
  SurfelCloud& cloud = loaded.cloud;
  if (!source.crease_angle || !source.triangles || loaded.triangles.empty()) return Done{};
  const std::vector<std::uint8_t> smooth = std::move(loaded.smooth);
  const std::vector<CornerNormals> corners = std::move(loaded.corner_normals);
  const std::size_t count = cloud.size();
  // No triangles are drawn between such (validate() of an object), with creases or without.
  if (!cloud.lifetime.empty() || (!smooth.empty() && smooth.size() != count))
    return Error{
        "", "triangles",
        "lie between points that come and go with the files of their sequence; \"draw\": \"surfels\" has "
        "discs drawn instead",
        ErrorKind::unsupported};
  Result<CreasedMesh> mesh = crease(cloud.keys[reference].pose.position.own(), loaded.triangles,
                                    *source.crease_angle * std::numbers::pi / 180.0, smooth, corners);
  if (!mesh) return mesh.error();

  append_copies(mesh->copies, cloud);
  std::vector<std::uint8_t> is_split(cloud.size(), 0);
  for (std::size_t k = 0; k < mesh->copies.size(); ++k) is_split[mesh->copies[k]] = is_split[count + k] = 1;
  std::vector<std::uint32_t> split;
  std::size_t points = 0;
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (is_split[i] != 0) {
      split.push_back(i);
      points += i < count ? 1 : 0;
    }
  std::vector<Triangle> about_them;
  for (const Triangle& t : mesh->triangles)
    if (is_split[t[0]] != 0 || is_split[t[1]] != 0 || is_split[t[2]] != 0) about_them.push_back(t);
  turn_split(split, about_them, cloud);
  if (source.color_by_normals && !source.color) {
    const SurfelPose& pose = cloud.keys[reference].pose;
    for (const std::uint32_t i : split) {
      const Eigen::Vector3d normal =
          pose.axis_u[i].cast<double>().cross(pose.axis_v[i].cast<double>()).stableNormalized();
      cloud.color[i] = (0.5 * (normal + Eigen::Vector3d::Ones())).cast<float>();
    }
  }
  tell(*mesh, points, loaded.report);
  loaded.triangles = std::move(mesh->triangles);
  loaded.copies = std::move(mesh->copies);
  return Done{};
}

}  // namespace swept::io
