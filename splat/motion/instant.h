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
  const Eigen::Matrix3d lens = lens_matrix(camera, scene.camera.at(exposure.middle()));
  const Eigen::Matrix3d rotation = camera.camera_from_world.linear();
  return {frame, object.transform.at(frame), lens.isIdentity(0.0) ? rotation : lens * rotation, camera.eye};
}

/// Whether object, points, their colours and the camera keep their bits over the whole exposure, of all rows.
[[nodiscard]] inline bool stands_still(const Scene& scene, const Object& object, const Exposure& exposure) {
  const Exposure all = exposure.of_all_rows(scene.film.height);
  return all.instant() || (!object.cloud.moves() && !looks_change(object.cloud, all.open, all.close) &&
                           !object.splats.moves() && object.transform.constant_over(all.open, all.close) &&
                           scene.camera.constant_over(all.open, all.close));
}

}  // namespace swept
