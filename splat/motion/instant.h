// One instant of the shutter: object, camera and lens folded into one map. Private to splat.
#pragma once

#include <Eigen/Geometry>

#include "splat/export.h"
#include "splat/motion/look.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

struct Instant {
  double frame = 0.0;
  Eigen::Affine3d world_from_object;
  /// Into the space of the projection at mid-shutter: a rotation, then lens_matrix(), so not rigid where the
  /// lens stretches or changes.
  Eigen::Matrix3d camera_from_world;
  Eigen::Vector3d eye;
  /// What that space is of the one that a still of this instant has: x and y times `zoom`, and `shift` times
  /// the depth added. Lengths in units of the film, as the depth tolerance is, are those of the still.
  double zoom = 1.0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  [[nodiscard]] bool zooms() const { return zoom != 1.0 || !shift.isZero(0.0); }
  /// From the space of the projection at mid-shutter to that of the still.
  [[nodiscard]] Eigen::Vector3d as_still(const Eigen::Vector3d& v) const {
    return {(v.x() - shift.x() * v.z()) / zoom, (v.y() - shift.y() * v.z()) / zoom, v.z()};
  }
  [[nodiscard]] Eigen::Vector3d to_camera(const Eigen::Vector3d& point) const {
    // The eye is subtracted in world space, where survey coordinates still have all their digits.
    return camera_from_world * (world_from_object * point - eye);
  }
  [[nodiscard]] Eigen::Vector3d to_camera_direction(const Eigen::Vector3d& direction) const {
    return camera_from_world * (world_from_object.linear() * direction);
  }
};

/// `shutter_time` in [0, 1], 0 being open.
[[nodiscard]] inline Instant instant_at(const Scene& scene, const Object& object, const Exposure& exposure,
                                        double shutter_time) {
  const double frame = exposure.at(shutter_time);
  const CameraInstant camera = scene.camera.at(frame);
  const CameraInstant middle = scene.camera.at(exposure.middle());
  const Eigen::Matrix3d lens = lens_matrix(camera, middle);
  const Eigen::Matrix3d rotation = camera.camera_from_world.linear();
  if (lens.isIdentity(0.0)) return {frame, object.transform.at(frame), rotation, camera.eye};
  const Projection own = projection_of(scene.film, camera), of_middle = projection_of(scene.film, middle);
  return {frame,
          object.transform.at(frame),
          lens * rotation,
          camera.eye,
          own.focal_px / of_middle.focal_px,
          Eigen::Vector2d(own.center_x - of_middle.center_x, own.center_y - of_middle.center_y) /
              of_middle.focal_px};
}

/// Whether object, points, their colours and the camera keep their bits over the whole exposure, of all rows.
[[nodiscard]] inline bool stands_still(const Scene& scene, const Object& object, const Exposure& exposure) {
  const Exposure all = exposure.of_all_rows(scene.film.height);
  return all.instant() || (!object.cloud.moves() && !looks_change(object.cloud, all.open, all.close) &&
                           !object.splats.moves() && object.transform.constant_over(all.open, all.close) &&
                           scene.camera.constant_over(all.open, all.close));
}

}  // namespace swept
