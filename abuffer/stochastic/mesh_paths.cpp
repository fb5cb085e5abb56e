#include "abuffer/stochastic/mesh_paths.h"

#include <algorithm>
#include <cmath>

#include <tbb/blocked_range.h>
#include <Eigen/LU>

#include "abuffer/parallel.h"
#include "splat/motion/instant.h"
#include "splat/motion/path.h"

namespace swept::stochastic {
namespace {

constexpr int most_halvings = 6;

/// Every point of the object at a time in [0, 1].
std::vector<Eigen::Vector3d> points_at(const Scene& scene, const Object& object, const Exposure& even,
                                       double time) {
  const Instant instant = instant_at(scene, object, even, time);
  const SurfelsAt surfels(object.cloud, instant.frame);
  std::vector<Eigen::Vector3d> points(object.cloud.size());
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, points.size(), 4096), [&](const auto& part) {
    for (std::size_t i = part.begin(); i != part.end(); ++i)
      points[i] = instant.to_camera(surfels[i].position);
  });
  return points;
}

/// How far the curve is from the path on the film, px, and a difference of depths as one to the side.
double off_px(const Eigen::Vector3d& curve, const Eigen::Vector3d& path, const Projection& film,
              double near) {
  const Eigen::Vector3d difference = curve - path;
  if (film.orthographic) return film.focal_px * difference.cwiseAbs().maxCoeff();
  const double depth = std::max(std::abs(path.z()), near);
  return film.focal_px * difference.cwiseAbs().maxCoeff() / depth *
         std::max(1.0, path.head<2>().cwiseAbs().maxCoeff() / depth);
}

}  // namespace

void MeshPaths::cut_at_keys(const Scene& scene, const Exposure& exposure) {
  cuts_ = {0.0, 1.0};
  if (exposure.instant()) return;
  std::vector<double> frames = path_corners(object_->cloud, exposure.open, exposure.close);
  for (const TransformKey& key : object_->transform.keys) frames.push_back(key.frame);
  for (const CameraKey& key : scene.camera.poses) frames.push_back(key.frame);
  for (const LookAtKey& key : scene.camera.look_ats) frames.push_back(key.frame);
  for (const double frame : frames) {
    const double time = (frame - exposure.open) / (exposure.close - exposure.open);
    if (time > 1e-9 && time < 1.0 - 1e-9) cuts_.push_back(time);
  }
  std::sort(cuts_.begin(), cuts_.end());
  cuts_.erase(std::unique(cuts_.begin(), cuts_.end(), [](double a, double b) { return b - a < 1e-9; }),
              cuts_.end());
}

MeshPaths::MeshPaths(const Scene& scene, const Object& object, const Exposure& exposure)
    : object_(&object), open_(exposure.open), close_(exposure.close) {
  if (!object.cloud.looks.empty()) opaque_looks_ = !object.cloud.see_through();
  const auto look_through = [&](const std::shared_ptr<const Texture>& texture) {
    if (texture)
      for (const Eigen::Vector4f& texel : texture->texels) opaque_looks_ = opaque_looks_ && texel.w() >= 1.0f;
  };
  look_through(object.texture);
  for (const Material& material : object.materials) {
    look_through(material.texture);
    opaque_looks_ = opaque_looks_ && material.opacity >= 1.0f;
  }
  // The shutter's curve says when samples look, and not how things move.
  const Exposure even{exposure.open, exposure.close};
  const Instant middle = instant_at(scene, object, even, 0.5);
  mirrored_ = (middle.camera_from_world * middle.world_from_object.linear()).determinant() < 0.0;
  const Projection film = projection_of(scene.film, scene.camera.at(exposure.middle()));
  const double near = scene.camera.near;
  cut_at_keys(scene, exposure);
  const std::vector<double> corners = cuts_;
  const bool still = stands_still(scene, object, exposure);

  for (int halvings = 0;; ++halvings) {
    const int parts = 1 << halvings;
    cuts_.clear();
    for (std::size_t i = 0; i + 1 < corners.size(); ++i)
      for (int k = 0; k < parts; ++k) cuts_.push_back(corners[i] + (corners[i + 1] - corners[i]) * k / parts);
    cuts_.push_back(1.0);
    const std::size_t count = object.cloud.size();
    stride_ = 2 * static_cast<std::size_t>(pieces()) + 1;
    controls_.resize(count * stride_);
    double worst = 0.0, bend = 0.0;
    std::vector<Eigen::Vector3d> begin = points_at(scene, object, even, still ? 0.5 : cut(0));
    for (int p = 0; p < pieces(); ++p) {
      const auto time = [&](double t) { return still ? 0.5 : cut(p) + t * (cut(p + 1) - cut(p)); };
      std::vector<Eigen::Vector3d> end = points_at(scene, object, even, time(1.0));
      const std::vector<Eigen::Vector3d> half = points_at(scene, object, even, time(0.5)),
                                         first = points_at(scene, object, even, time(0.25)),
                                         last = points_at(scene, object, even, time(0.75));
      for (std::size_t i = 0; i < count; ++i) {
        Eigen::Vector3d* const control = &controls_[i * stride_ + 2 * static_cast<std::size_t>(p)];
        control[0] = begin[i];
        control[1] = 2.0 * half[i] - 0.5 * (begin[i] + end[i]);
        control[2] = end[i];
        const auto curve = [&](double t) -> Eigen::Vector3d {
          return (1 - t) * (1 - t) * control[0] + 2 * t * (1 - t) * control[1] + t * t * control[2];
        };
        worst = std::max(
            {worst, off_px(curve(0.25), first[i], film, near), off_px(curve(0.75), last[i], film, near)});
        bend = std::max(bend, off_px(0.5 * (begin[i] + end[i]), half[i], film, near));
      }
      begin = std::move(end);
    }
    degree_ = bend > 1e-9 ? 2 : 1;
    if (!(worst > path_tolerance_px) || halvings == most_halvings) break;
  }
  if (degree_ == 1)  // and no rest of it, so that bounds by the ends alone hold
    for (std::size_t i = 0; i < object.cloud.size(); ++i)
      for (std::size_t p = 0; p + 2 < stride_; p += 2) {
        Eigen::Vector3d* const control = &controls_[i * stride_ + p];
        control[1] = 0.5 * (control[0] + control[2]);
      }
}

}  // namespace swept::stochastic
