// One instant of the shutter: object and camera folded into one map. Private to splat.
#pragma once

#include <Eigen/Geometry>

#include "splat/scene.h"

namespace swept {

struct Instant {
  double frame = 0.0;
  Eigen::Affine3d world_from_object;
  Eigen::Matrix3d camera_from_world;
  Eigen::Vector3d eye;
  double zoom = 1.0;  ///< focal length relative to that at mid-shutter, which the projection has

  [[nodiscard]] Eigen::Vector3d to_camera(const Eigen::Vector3d& point) const {
    // The eye is subtracted in world space, where survey coordinates still have all their digits.
    Eigen::Vector3d p = camera_from_world * (world_from_object * point - eye);
    p.head<2>() *= zoom;
    return p;
  }
  [[nodiscard]] Eigen::Vector3d to_camera_direction(const Eigen::Vector3d& direction) const {
    Eigen::Vector3d p = camera_from_world * (world_from_object.linear() * direction);
    p.head<2>() *= zoom;
    return p;
  }
};

/// `shutter_time` in [0, 1], 0 being open.
[[nodiscard]] inline Instant instant_at(const Scene& scene, const Object& object, const Exposure& exposure,
                                        double shutter_time) {
  const double frame = exposure.at(shutter_time);
  const CameraInstant camera = scene.camera.at(frame);
  const double reference = scene.camera.at(exposure.middle()).tan_half_fov_y;
  return {frame, object.transform.at(frame), camera.camera_from_world.linear(), camera.eye,
          reference / camera.tan_half_fov_y};
}

/// Whether object, points and camera keep their bits over the whole exposure.
[[nodiscard]] inline bool stands_still(const Scene& scene, const Object& object, const Exposure& exposure) {
  return exposure.instant() ||
         (!object.cloud.moves() && object.transform.constant_over(exposure.open, exposure.close) &&
          scene.camera.constant_over(exposure.open, exposure.close));
}

}  // namespace swept
