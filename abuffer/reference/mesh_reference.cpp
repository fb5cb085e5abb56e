#include "abuffer/reference/mesh_reference.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/LU>

#include "abuffer/reference/posed_scene.h"
#include "abuffer/reference/ray_triangle.h"
#include "splat/interval/pixel_places.h"
#include "splat/motion/instant.h"

namespace swept::reference {
namespace {

/// The mean of the four texels about (u, v), by how near their middles are.
Eigen::Vector4d texture_at(const Texture& texture, const Eigen::Vector2d& uv) {
  const double x = uv.x() * texture.width, y = (1.0 - uv.y()) * texture.height;
  const auto repeated = [](double index, int count) {
    return static_cast<std::size_t>(index - count * std::floor(index / count));
  };
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (double j = std::floor(y - 0.5); j <= std::floor(y - 0.5) + 1.0; j += 1.0)
    for (double i = std::floor(x - 0.5); i <= std::floor(x - 0.5) + 1.0; i += 1.0) {
      const double near_x = 1.0 - std::abs(x - (i + 0.5)), near_y = 1.0 - std::abs(y - (j + 0.5));
      const std::size_t texel =
          repeated(j, texture.height) * static_cast<std::size_t>(texture.width) + repeated(i, texture.width);
      sum += near_x * near_y * texture.texels[texel].cast<double>();
    }
  return sum;
}

}  // namespace

MeshAt::MeshAt(const Scene& scene, const Object& object, double frame)
    : projection_(projection_of(scene.film, scene.camera.at(frame))), near_(scene.camera.near) {
  const Film& film = scene.film;
  const PixelBox window{film.crop_x, film.crop_y, film.crop_x + film.window_width(),
                        film.crop_y + film.window_height()};
  const Instant instant = instant_at(scene, object, {frame, frame}, 0.0);
  const bool mirrored = (instant.camera_from_world * instant.world_from_object.linear()).determinant() < 0.0;
  first_row_ = window.y_begin;
  of_row_.resize(static_cast<std::size_t>(film.window_height()));
  for (std::size_t t = 0; t < object.triangles.size(); ++t) {
    const Triangle& triangle = object.triangles[t];
    Corners corners;
    Eigen::Vector4d tint = Eigen::Vector4d::Ones();
    corners.texture = object.texture.get();
    if (!object.materials.empty()) {
      const Material& material = object.materials[object.material_of[t]];
      const double opacity = double{material.opacity};
      tint << opacity * material.color.cast<double>(), opacity;
      corners.texture = material.texture.get();
    }
    bool in_front = true;
    Eigen::Array2d low = Eigen::Array2d::Constant(1e30), high = -low;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t point = triangle[i];
      corners.at[i] = instant.to_camera(surfel_at(object.cloud, point, frame).position);
      corners.color[i] = tint.cwiseProduct(light_of(object.cloud, point, frame));
      if (corners.texture != nullptr) corners.uv[i] = object.texture_corners[t][i].cast<double>();
      in_front = in_front && corners.at[i].z() > near_;
      const Eigen::Array2d film_at =
          Eigen::Array2d(projection_.center_x, projection_.center_y) +
          projection_.focal_px * corners.at[i].head<2>().array() / projection_.divisor(corners.at[i].z());
      low = low.min(film_at);
      high = high.max(film_at);
    }
    const Eigen::Vector3d normal = (corners.at[1] - corners.at[0]).cross(corners.at[2] - corners.at[0]);
    const double away = projection_.orthographic ? normal.z() : normal.dot(corners.at[0]);
    const bool front = (away < 0.0) != mirrored;
    if (!object.two_sided && !front) continue;
    // What reaches behind the eye may be anywhere.
    const auto pixel = [](double v, int begin, int end) {
      return static_cast<int>(std::clamp<double>(std::floor(v), begin, end));
    };
    corners.box = window;
    if (in_front)
      corners.box = {pixel(low.x() - 1.0, window.x_begin, window.x_end),
                     pixel(low.y() - 1.0, window.y_begin, window.y_end),
                     pixel(high.x() + 2.0, window.x_begin, window.x_end),
                     pixel(high.y() + 2.0, window.y_begin, window.y_end)};
    if (corners.box.empty()) continue;
    for (int y = corners.box.y_begin; y < corners.box.y_end; ++y)
      of_row_[static_cast<std::size_t>(y - first_row_)].push_back(
          static_cast<std::uint32_t>(triangles_.size()));
    triangles_.push_back(corners);
  }
}

void MeshAt::meet(int x, int y, std::vector<Surface>& surfaces) const {
  struct Hit {
    double depth;
    Eigen::Vector4d color;
  };
  std::vector<Hit> hits[pixel_places];
  std::size_t most = 0;
  for (int k = 0; k < pixel_places; ++k) {
    const Ray ray =
        ray_at(projection_, x + 0.5 + double{places_in_pixel.x[k]}, y + 0.5 + double{places_in_pixel.y[k]});
    for (const std::uint32_t t : of_row_[static_cast<std::size_t>(y - first_row_)]) {
      const Corners& corners = triangles_[t];
      if (x < corners.box.x_begin || x >= corners.box.x_end) continue;
      const std::optional<RayHit> hit = meet_triangle(corners.at, ray, near_);
      if (!hit) continue;
      const Eigen::Vector3d& share = hit->share;
      Eigen::Vector4d color =
          share[0] * corners.color[0] + share[1] * corners.color[1] + share[2] * corners.color[2];
      if (corners.texture != nullptr)
        color = color.cwiseProduct(
            texture_at(*corners.texture,
                       share[0] * corners.uv[0] + share[1] * corners.uv[1] + share[2] * corners.uv[2]));
      hits[k].push_back({hit->depth, color});
    }
    std::stable_sort(hits[k].begin(), hits[k].end(),
                     [](const Hit& a, const Hit& b) { return a.depth < b.depth; });
    most = std::max(most, hits[k].size());
  }
  double light[pixel_places];  // that reaches the layer
  std::fill(light, light + pixel_places, 1.0);
  constexpr double no_light = 1e-12;
  for (std::size_t layer = 0; layer < most; ++layer) {
    double before = 0.0, taken = 0.0, depth = 0.0;
    Eigen::Vector4d color = Eigen::Vector4d::Zero();
    for (int k = 0; k < pixel_places; ++k) {
      before += light[k] / pixel_places;
      if (hits[k].size() <= layer) continue;
      const Hit& hit = hits[k][layer];
      const double alpha = light[k] * hit.color.w() / pixel_places;
      color += light[k] * hit.color / pixel_places;
      taken += alpha;
      depth += alpha * hit.depth;
      light[k] *= 1.0 - hit.color.w();
    }
    if (!(before > no_light)) break;
    if (taken > 0.0) surfaces.push_back({color / before, depth / taken, 1.0});
  }
}

}  // namespace swept::reference
