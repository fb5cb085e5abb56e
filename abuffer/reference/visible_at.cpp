#include "abuffer/reference/visible_at.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/LU>

#include "abuffer/parallel.h"
#include "abuffer/reference/ray_triangle.h"
#include "splat/interval/pixel_places.h"
#include "splat/motion/instant.h"

namespace swept::reference {
namespace {

/// The film at one instant: the nearest depth at each place so far.
class InstantFilm {
 public:
  InstantFilm(const Scene& scene, double time, std::size_t index, VisibleTriangles& visible)
      : scene_(scene),
        time_(time),
        index_(index),
        visible_(visible),
        projection_(projection_of(scene.film, scene.camera.at(scene.exposure().middle()))),
        depth_(
            static_cast<std::size_t>(visible.width) * static_cast<std::size_t>(visible.height) * pixel_places,
            std::numeric_limits<double>::infinity()) {}

  void draw(const Object& object, std::uint32_t first_triangle) {
    // The shutter's curve says how much light there is, and not where things are.
    const Exposure shutter = scene_.exposure();
    const Instant instant = instant_at(scene_, object, {shutter.open, shutter.close}, time_);
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < object.cloud.size(); ++i)
      points.push_back(instant.to_camera(surfel_at(object.cloud, i, instant.frame).position));
    const bool mirrored =
        (instant.camera_from_world * instant.world_from_object.linear()).determinant() < 0.0;
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
      const Eigen::Vector3d p[3] = {points[object.triangles[t][0]], points[object.triangles[t][1]],
                                    points[object.triangles[t][2]]};
      const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
      const double away = projection_.orthographic ? normal.z() : normal.dot(p[0]);
      const bool front = (away < 0.0) != mirrored;
      if (object.two_sided || front) draw(p, first_triangle + static_cast<std::uint32_t>(t));
    }
  }

 private:
  void draw(const Eigen::Vector3d (&p)[3], std::uint32_t triangle) {
    const double near = scene_.camera.near;
    const Film& film = scene_.film;
    int box[4] = {0, 0, visible_.width - 1, visible_.height - 1};  // what reaches behind the eye: anywhere
    if (p[0].z() < near && p[1].z() < near && p[2].z() < near) return;
    if (p[0].z() >= near && p[1].z() >= near && p[2].z() >= near) {
      Eigen::Array2d low = Eigen::Array2d::Constant(1e30), high = -low;
      for (const Eigen::Vector3d& corner : p) {
        const Eigen::Array2d at =
            Eigen::Array2d(projection_.center_x, projection_.center_y) +
            projection_.focal_px * corner.head<2>().array() / projection_.divisor(corner.z());
        low = low.min(at);
        high = high.max(at);
      }
      const auto pixel = [](double v, int last) {
        return static_cast<int>(std::clamp<double>(std::floor(v), -1.0, last + 1.0));
      };
      const double hair = 1e-3;
      box[0] = std::max(0, pixel(low.x() - film.crop_x - hair, visible_.width));
      box[1] = std::max(0, pixel(low.y() - film.crop_y - hair, visible_.height));
      box[2] = std::min(box[2], pixel(high.x() - film.crop_x + hair, visible_.width));
      box[3] = std::min(box[3], pixel(high.y() - film.crop_y + hair, visible_.height));
    }
    for (int y = box[1]; y <= box[3]; ++y)
      for (int x = box[0]; x <= box[2]; ++x) {
        const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(visible_.width) +
                                  static_cast<std::size_t>(x);
        for (std::size_t k = 0; k < pixel_places; ++k) {
          const Ray ray = ray_at(projection_, film.crop_x + x + 0.5 + double{places_in_pixel.x[k]},
                                 film.crop_y + y + 0.5 + double{places_in_pixel.y[k]});
          const std::optional<RayHit> hit = meet_triangle(p, ray, near);
          double& nearest = depth_[pixel * pixel_places + k];
          if (!hit || !(hit->depth < nearest)) continue;
          nearest = hit->depth;
          visible_.triangle[(pixel * pixel_places + k) * visible_.times + index_] = triangle;
        }
      }
  }

  const Scene& scene_;
  double time_;
  std::size_t index_;
  VisibleTriangles& visible_;
  Projection projection_;
  std::vector<double> depth_;
};

}  // namespace

VisibleTriangles triangles_at(const Scene& scene, const std::vector<double>& times) {
  VisibleTriangles visible;
  visible.width = scene.film.window_width(), visible.height = scene.film.window_height();
  visible.times = times.size();
  visible.triangle.assign(static_cast<std::size_t>(visible.width) * static_cast<std::size_t>(visible.height) *
                              pixel_places * times.size(),
                          no_triangle);
  parallel_for_each_index(times.size(), [&](std::size_t i) {
    InstantFilm film(scene, times[i], i, visible);
    std::uint32_t first = 0;
    for (const Object& object : scene.objects) {
      film.draw(object, first);
      first += static_cast<std::uint32_t>(object.triangles.size());
    }
  });
  return visible;
}

}  // namespace swept::reference
