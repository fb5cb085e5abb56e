#include "abuffer/reference/mesh_layers_at.h"

#include <cstddef>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "abuffer/reference/ray_triangle.h"
#include "splat/camera.h"
#include "splat/interval/pixel_places.h"
#include "splat/surfel.h"

namespace swept::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Where rays see an object of the scene.
class LooksAtMesh {
 public:
  LooksAtMesh(const Scene& scene, const Object& object)
      : scene_(scene),
        object_(object),
        middle_(scene.exposure().middle()),
        camera_(scene.camera.at(middle_)),
        film_(projection_of(scene.film, camera_)),
        world_(object.transform.at(middle_)) {}

  /// Adds what a ray through a place of the film, px, meets first; its depth, if it meets anything.
  std::optional<double> add(double x, double y, LayersOfPixel& sum) const {
    const Ray ray = ray_at(film_, x, y);
    std::optional<RayHit> hit;
    const Triangle* met = nullptr;
    for (const Triangle& triangle : object_.triangles)
      if (const auto found = meet(triangle, ray); found && (!hit || found->depth < hit->depth)) {
        hit = found;
        met = &triangle;
      }
    if (!hit) return std::nullopt;
    sum.normal += normal_of(*met, hit->share, ray);
    const double open = scene_.exposure().open, close = scene_.exposure().close;
    const OnFilm there = at(*met, hit->share, middle_), to = at(*met, hit->share, close),
                 from = at(*met, hit->share, open);
    if (to.depth >= scene_.camera.near) sum.forward += (to.place - there.place) / (close - middle_);
    if (from.depth >= scene_.camera.near) sum.backward += (from.place - there.place) / (middle_ - open);
    return hit->depth;
  }

 private:
  struct OnFilm {
    Vector2d place;  ///< px, y up
    double depth;
  };

  [[nodiscard]] std::optional<RayHit> meet(const Triangle& triangle, const Ray& ray) const {
    Vector3d p[3];
    for (std::size_t i = 0; i < 3; ++i)
      p[i] = camera_.camera_from_world.linear() *
             (world_ * surfel_at(object_.cloud, triangle[i], middle_).position - camera_.eye);
    const bool mirrored =
        (world_.linear().determinant() < 0.0) != (camera_.camera_from_world.linear().determinant() < 0.0);
    const bool front = ((p[1] - p[0]).cross(p[2] - p[0]).dot(ray.direction) < 0.0) != mirrored;
    if (!object_.two_sided && !front) return std::nullopt;
    return meet_triangle(p, ray, scene_.camera.near);
  }

  [[nodiscard]] Vector3d normal_of(const Triangle& triangle, const Vector3d& share, const Ray& ray) const {
    const Eigen::Matrix3d normals = world_.linear().inverse().transpose();
    Vector3d normal = Vector3d::Zero(), corner[3];
    for (int i = 0; i < 3; ++i) {
      const SurfelInstant s = surfel_at(object_.cloud, triangle[static_cast<std::size_t>(i)], middle_);
      normal += share[i] * (normals * s.axis_u.cross(s.axis_v)).normalized();
      corner[i] = world_ * s.position;
    }
    // Of the side that is seen.
    Vector3d face = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (face.dot(camera_.camera_from_world.linear().transpose() * ray.direction) > 0.0) face = -face;
    if (normal.dot(face) < 0.0) normal = -normal;
    return normal.normalized();
  }

  [[nodiscard]] OnFilm at(const Triangle& triangle, const Vector3d& share, double frame) const {
    Vector3d in_object = Vector3d::Zero();
    for (int i = 0; i < 3; ++i)
      in_object += share[i] * surfel_at(object_.cloud, triangle[static_cast<std::size_t>(i)], frame).position;
    const CameraInstant camera = scene_.camera.at(frame);
    const Vector3d p =
        camera.camera_from_world.linear() * (object_.transform.at(frame) * in_object - camera.eye);
    const Projection film = projection_of(scene_.film, camera);
    const double divisor = film.divisor(p.z());
    return {
        {film.center_x + film.focal_px * p.x() / divisor, -film.center_y - film.focal_px * p.y() / divisor},
        p.z()};
  }

  const Scene& scene_;
  const Object& object_;
  double middle_;
  CameraInstant camera_;
  Projection film_;
  Eigen::Affine3d world_;
};

}  // namespace

LayersOfPixel mesh_layers_at(const Scene& scene, int x, int y) {
  LayersOfPixel best;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Object& object : scene.objects) {
    const LooksAtMesh mesh(scene, object);
    LayersOfPixel sum;
    double depths = 0.0;
    int met = 0;
    for (std::size_t k = 0; k < pixel_places; ++k)
      if (const auto depth =
              mesh.add(x + 0.5 + double{places_in_pixel.x[k]}, y + 0.5 + double{places_in_pixel.y[k]}, sum)) {
        depths += *depth;
        ++met;
      }
    if (met == 0 || !(depths / met < nearest)) continue;
    nearest = depths / met;
    best = {sum.normal.normalized(), sum.forward / met, sum.backward / met,
            met / static_cast<double>(pixel_places)};
  }
  return best;
}

}  // namespace swept::reference
