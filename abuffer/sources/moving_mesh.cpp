#include "abuffer/sources/moving_mesh.h"

#include <algorithm>
#include <cmath>

#include <tbb/blocked_range.h>
#include <Eigen/LU>

#include "abuffer/parallel.h"
#include "abuffer/tiles/path_frames.h"
#include "splat/motion/instant.h"
#include "splat/motion/look.h"
#include "splat/motion/path.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

/// Whether the map from object to camera changes by nothing but its translation, evenly from key to key.
bool only_shifts(const Scene& scene, const Object& object, const Exposure& exposure) {
  const auto alike = [](const auto& keys, const auto& same) {
    return std::all_of(keys.begin(), keys.end(), [&](const auto& key) { return same(key, keys.front()); });
  };
  if (!object.transform.constant_over(exposure.open, exposure.close) &&
      !alike(object.transform.keys, [](const TransformKey& a, const TransformKey& b) {
        return a.rotate_axis == b.rotate_axis && a.rotate_radians == b.rotate_radians && a.scale == b.scale;
      }))
    return false;
  if (scene.camera.constant_over(exposure.open, exposure.close)) return true;
  return scene.camera.look_ats.empty() && scene.camera.lens_point.isZero(0.0) &&
         alike(scene.camera.poses, [](const CameraKey& a, const CameraKey& b) {
           return a.world_from_camera.coeffs() == b.world_from_camera.coeffs() &&
                  a.tan_half_fov_y == b.tan_half_fov_y && a.lens == b.lens;
         });
}

/// Whether paths are polynomials of a degree ≤ `most_degree` in camera space.
bool are_polynomials(const Scene& scene, const Object& object, const Exposure& exposure, int most_degree) {
  return only_shifts(scene, object, exposure) &&
         path_degree(object.cloud) <= static_cast<std::size_t>(most_degree);
}

/// Frames between which nothing has a corner, from the exposure's open to its close.
std::vector<double> smooth_spans(const Scene& scene, const Object& object, const Exposure& exposure,
                                 bool polynomials) {
  std::vector<double> frames = path_corners(object.cloud, exposure.open, exposure.close);
  const std::vector<double> look_frames = look_corners(object.cloud, exposure.open, exposure.close);
  frames.insert(frames.end(), look_frames.begin(), look_frames.end());
  std::sort(frames.begin(), frames.end());
  // No curve may bend both ways between two looks at it.
  const std::size_t parts = path_degree(object.cloud) > 2 ? path_degree(object.cloud) : 1;
  std::vector<double> looks;
  if (!polynomials)
    for (std::size_t k = 0; k <= frames.size(); ++k) {
      const double first = k == 0 ? exposure.open : frames[k - 1],
                   last = k == frames.size() ? exposure.close : frames[k];
      for (std::size_t part = 1; part < parts; ++part)
        looks.push_back(first + (last - first) * static_cast<double>(part) / static_cast<double>(parts));
    }
  frames.insert(frames.end(), looks.begin(), looks.end());
  if (!only_shifts(scene, object, exposure)) return path_frames(scene, object, frames, exposure);
  frames.push_back(exposure.open);
  frames.push_back(exposure.close);
  const auto add_keys = [&](const auto& keys) {
    for (const auto& key : keys)
      if (key.frame > exposure.open && key.frame < exposure.close) frames.push_back(key.frame);
  };
  add_keys(object.transform.keys);
  add_keys(scene.camera.poses);
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

/// All points at instants of one object.
class Looks {
 public:
  Looks(const Scene& scene, const Object& object, const Exposure& exposure)
      : scene_(scene), object_(object), exposure_(exposure) {}

  [[nodiscard]] Instant instant(double frame) const {
    const CameraInstant camera = scene_.camera.at(frame);
    const Eigen::Matrix3d lens = lens_matrix(camera, scene_.camera.at(exposure_.middle()));
    const Eigen::Matrix3d rotation = camera.camera_from_world.linear();
    return {frame, object_.transform.at(frame), lens.isIdentity(0.0) ? rotation : lens * rotation,
            camera.eye};
  }
  [[nodiscard]] std::vector<Eigen::Vector3d> at(double frame) const {
    const Instant seen = instant(frame);
    const SurfelsAt points(object_.cloud, frame);
    std::vector<Eigen::Vector3d> result(object_.cloud.size());
    parallel_for_parts(tbb::blocked_range<std::size_t>(0, result.size(), 4096), [&](const auto& part) {
      for (std::size_t i = part.begin(); i != part.end(); ++i) result[i] = seen.to_camera(points.position(i));
    });
    return result;
  }

 private:
  const Scene& scene_;
  const Object& object_;
  const Exposure& exposure_;
};

}  // namespace

double off_path_px(const Eigen::Vector3d& curve, const Eigen::Vector3d& truth, const Projection& film,
                   double near, double most_tangent) {
  const double off = (curve - truth).norm();
  if (film.orthographic) return film.focal_px * off;
  const auto depth = [&](const Eigen::Vector3d& p) { return std::max(std::abs(p.z()), near); };
  const auto tangent = [&](const Eigen::Vector3d& p) { return p.head<2>().norm() / depth(p); };
  const double across = std::min(std::max(tangent(curve), tangent(truth)), most_tangent);
  const double distance = std::hypot(curve.head<2>().norm(), depth(curve));
  return film.focal_px * (off / distance) * (1.0 + across * across);
}

double film_tangent(const Scene& scene, const Exposure& exposure) {
  const Projection film = projection_of(scene.film, scene.camera.at(exposure.middle()));
  return film.orthographic
             ? 0.0
             : std::hypot(largest_tangent(scene.film, film, 0), largest_tangent(scene.film, film, 1));
}

Result<MovingMesh> MovingMesh::follow(const Scene& scene, const Object& object, const Exposure& exposure,
                                      double tolerance_px, int most_degree, double most_tangent,
                                      const std::stop_token& stop) {
  MovingMesh mesh;
  mesh.object_ = &object;
  mesh.open_ = exposure.open, mesh.close_ = exposure.close;
  const auto opaque = [](const std::shared_ptr<const Texture>& texture) {
    return !texture || std::all_of(texture->texels.begin(), texture->texels.end(),
                                   [](const Eigen::Vector4f& texel) { return texel.w() >= 1.0f; });
  };
  if (object.materials.empty()) mesh.opaque_textures_.push_back(opaque(object.texture));
  for (const Material& material : object.materials) mesh.opaque_textures_.push_back(opaque(material.texture));
  const SurfelCloud& cloud = object.cloud;
  const Looks looks(scene, object, exposure);
  const auto end_at = [&](double shutter_time, double middle_frame) {
    const Instant middle = looks.instant(middle_frame);
    mesh.mirrored_.push_back((middle.camera_from_world * middle.world_from_object.linear()).determinant() <
                             0.0);
    mesh.times_.push_back(shutter_time);
  };
  mesh.times_.push_back(0.0);
  if (stands_still(scene, object, exposure)) {
    end_at(1.0, exposure.middle());
    for (const Eigen::Vector3d& p : looks.at(exposure.middle())) {
      mesh.controls_.push_back(p);
      mesh.controls_.push_back(p);
    }
    return mesh;
  }
  const bool polynomials = are_polynomials(scene, object, exposure, most_degree);
  const std::vector<double> frames = smooth_spans(scene, object, exposure, polynomials);
  if (frames.size() < 2)
    return Error{"", "/objects",
                 "has a mesh that turns too fast for its paths to be followed; --method sampled does",
                 ErrorKind::unsupported};
  const auto time = [&](double frame) {
    return frame == exposure.close ? 1.0 : (frame - exposure.open) / (exposure.close - exposure.open);
  };
  if (polynomials) {
    mesh.degree_ = static_cast<int>(std::max<std::size_t>(1, path_degree(cloud)));
    const auto controls = static_cast<std::size_t>(mesh.degree_) + 1;
    mesh.controls_.resize((frames.size() - 1) * cloud.size() * controls);
    for (std::size_t s = 0; s + 1 < frames.size(); ++s) {
      const std::vector<PathWeights> weights = path_controls(cloud, frames[s], frames[s + 1]);
      for (std::size_t k = 0; k < controls; ++k) {
        // What shifts evenly has control points at evenly spaced times.
        const double share = static_cast<double>(k) / mesh.degree_;
        const Instant seen = looks.instant(frames[s] + (frames[s + 1] - frames[s]) * share);
        const SurfelsAt points(cloud, weights[k]);
        for (std::size_t i = 0; i < cloud.size(); ++i)
          mesh.controls_[(s * cloud.size() + i) * controls + k] = seen.to_camera(points.position(i));
      }
      end_at(time(frames[s + 1]), 0.5 * frames[s] + 0.5 * frames[s + 1]);
    }
    return mesh;
  }
  mesh.degree_ = 2;
  const Projection projection = projection_of(scene.film, scene.camera.at(exposure.middle()));
  using Points = std::vector<Eigen::Vector3d>;
  const auto far_off = [&](const Points& a, const Points& m, const Points& b, const Points& truth, double t) {
    // What a parabola through three places leaves of a cubic is t (t − ½)(t − 1) times a constant: at most
    // 1.03 of what it is in these two. The rest is for terms beyond, of stretches that turn by a quarter.
    constexpr double between = 1.1;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const Eigen::Vector3d p =
          (1.0 - t) * (1.0 - 2.0 * t) * a[i] + 4.0 * t * (1.0 - t) * m[i] + t * (2.0 * t - 1.0) * b[i];
      if (between * off_path_px(p, truth[i], projection, scene.camera.near, most_tangent) > tolerance_px)
        return true;
    }
    return false;
  };
  const auto cut = [&](const auto& self, double first, const Points& a, double last, const Points& b,
                       int halvings) -> void {
    if (stop.stop_requested()) throw Stopped();
    const double half = 0.5 * first + 0.5 * last;
    const Points m = looks.at(half);
    if (halvings > 0 && (far_off(a, m, b, looks.at(0.75 * first + 0.25 * last), 0.25) ||
                         far_off(a, m, b, looks.at(0.25 * first + 0.75 * last), 0.75))) {
      self(self, first, a, half, m, halvings - 1);
      self(self, half, m, last, b, halvings - 1);
      return;
    }
    for (std::size_t i = 0; i < m.size(); ++i) {
      mesh.controls_.push_back(a[i]);
      mesh.controls_.emplace_back(2.0 * m[i] - 0.5 * (a[i] + b[i]));
      mesh.controls_.push_back(b[i]);
    }
    end_at(time(last), half);
  };
  Points first = looks.at(frames.front());
  for (std::size_t s = 0; s + 1 < frames.size(); ++s) {
    Points last = looks.at(frames[s + 1]);
    cut(cut, frames[s], first, frames[s + 1], last, 8);
    first = std::move(last);
  }
  return mesh;
}

}  // namespace swept
