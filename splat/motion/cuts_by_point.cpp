// Which objects are worth cutting point by point (cut.h).
#include <algorithm>
#include <cmath>

#include "splat/motion/cut.h"
#include "splat/motion/path.h"
#include "splat/motion/rims.h"

namespace swept {
namespace {

/// Whether keys that the exposure lies between differ by what is not a translation.
bool object_turns(const TransformTrack& track, double open, double close) {
  const auto same = [](const TransformKey& a, const TransformKey& b) {
    return a.rotate_radians == b.rotate_radians && a.rotate_axis == b.rotate_axis && a.scale == b.scale;
  };
  for (std::size_t k = 1; k < track.keys.size(); ++k)
    if (track.keys[k - 1].frame < close && track.keys[k].frame > open &&
        !same(track.keys[k - 1], track.keys[k]))
      return true;
  return false;
}

/// The same of the camera: looks that keep their direction while eye and target move are told by the frames'
/// matrices, whole turns of the roll by the keys.
bool camera_turns(const Scene& scene, const Object& object, const Exposure& exposure) {
  const std::vector<LookAtKey>& looks = scene.camera.look_ats;
  for (std::size_t k = 1; k < looks.size(); ++k)
    if (looks[k - 1].frame < exposure.close && looks[k].frame > exposure.open &&
        looks[k - 1].roll_radians != looks[k].roll_radians)
      return true;
  constexpr double rounding = 1e-12;
  const Eigen::Matrix3d first = instant_at(scene, object, exposure, 0.0).camera_from_world;
  const auto differs = [&](double time) {
    return !((instant_at(scene, object, exposure, time).camera_from_world - first).norm() <=
             rounding * first.norm());
  };
  return differs(0.5) || differs(1.0);
}

/// Whether a path may have a corner within the exposure that is not one of its points' own.
bool has_keys_within(const Scene& scene, const Object& object, const Exposure& exposure) {
  const auto within = [&](const auto& keys) {
    return std::any_of(keys.begin(), keys.end(), [&](const auto& key) {
      return key.frame > exposure.open && key.frame < exposure.close;
    });
  };
  return within(object.transform.keys) || within(scene.camera.poses) || within(scene.camera.look_ats);
}

/// Whether any point comes or goes while the shutter is open: its part of a segment is not about the middle.
bool comes_or_goes(const SurfelCloud& cloud, const Exposure& exposure) {
  return std::any_of(cloud.lifetime.begin(), cloud.lifetime.end(), [&](const Lifetime& life) {
    const auto within = [&](double frame) { return frame > exposure.open && frame < exposure.close; };
    return within(life.born) || within(life.gone);
  });
}

DiscAxes axes_at(const Instant& instant, const SurfelInstant& surfel) {
  return {instant.to_camera_direction(surfel.axis_u), instant.to_camera_direction(surfel.axis_v)};
}

/// How far the rims of two poses of a disc are apart, seen at one place.
double rims_apart_px(const DiscAxes& a, const DiscAxes& b, const Projection& projection,
                     const Eigen::Vector3d& at) {
  if (a.u == b.u && a.v == b.v) return 0.0;
  const Eigen::Vector2d ray =
      projection.orthographic ? Eigen::Vector2d::Zero() : Eigen::Vector2d(at.head<2>() / at.z());
  return rims_apart_px(a, b, ray.x(), ray.y(), projection.focal_px / projection.divisor(at.z()));
}

/// By how much a disc may become wider or narrower on the film on its way from `a` to `b`.
double seen_from_aside_px(const DiscAxes& axes, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                          const Projection& projection, double near) {
  if (!(std::min(a.z(), b.z()) > near)) return 0.0;
  const Eigen::Vector2d aside = b.head<2>() / b.z() - a.head<2>() / a.z();
  return projection.focal_px / std::min(a.z(), b.z()) * aside.norm() * std::hypot(axes.u.z(), axes.v.z());
}

/// Whether any point may come so much nearer, or go so much farther away, that the pixel filter of a
/// segment's middle is not that of its ends, or the axes of any disc change from key to key.
bool discs_change(const Scene& scene, const Object& object, const Exposure& exposure) {
  const bool filter_may = scene.model.filter_radius_px > 0.0 && !scene.camera.orthographic;
  const bool axes_may = object.cloud.keys.size() > 1;
  if (!filter_may && !axes_may) return false;
  std::vector<double> frames = path_corners(object.cloud, exposure.open, exposure.close);
  frames.insert(frames.begin(), exposure.open);
  frames.push_back(exposure.close);
  const double least = filters_per_path * path_tolerance_px(scene) / scene.model.filter_radius_px;
  const Projection projection = projection_of(scene.film, scene.camera.at(exposure.middle()));
  const double least_aside_px =
      2.0 * filters_per_path * path_tolerance_px(scene) * std::min(1.0, scene.model.filter_radius_px);
  // Half of it from the middle.
  const double least_rim_px = 2.0 * rims_per_path * path_tolerance_px(scene);
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const auto at = [&](double frame) {
      return instant_at(scene, object, exposure, exposure.share_at(frame));
    };
    const Instant first = at(frames[k - 1]), last = at(frames[k]);
    const SurfelsAt before(object.cloud, first.frame), after(object.cloud, last.frame);
    for (std::size_t i = 0; i < object.cloud.size(); ++i) {
      const SurfelInstant from = before[i], to = after[i];
      const Eigen::Vector3d a = first.to_camera(from.position), b = last.to_camera(to.position);
      if (!(std::max(a.z(), b.z()) > scene.camera.near)) continue;
      if (filter_may &&
          (filter_may_differ(a.z(), b.z(), scene.camera.near, least) ||
           seen_from_aside_px(axes_at(first, from), a, b, projection, scene.camera.near) > least_aside_px))
        return true;
      if (axes_may && a.z() + b.z() > 2.0 * scene.camera.near &&
          rims_apart_px(axes_at(first, from), axes_at(last, to), projection, 0.5 * (a + b)) > least_rim_px)
        return true;
    }
  }
  return false;
}

}  // namespace

bool cuts_by_point(const Scene& scene, const Object& object, const Exposure& exposure) {
  if (stands_still(scene, object, exposure) || object.discs() == 0) return false;
  if (exposure.row_delay != 0.0) return true;
  // Segments that are all alike would miss the corners of looks.
  return object.segments == 0 && scene.model.segments == 0 &&
         (object.cloud.curved() || scene.motion.tolerance_px > 0.0 ||
          looks_change(object.cloud, exposure.open, exposure.close) ||
          object_turns(object.transform, exposure.open, exposure.close) ||
          camera_turns(scene, object, exposure) || has_keys_within(scene, object, exposure) ||
          comes_or_goes(object.cloud, exposure) || discs_change(scene, object, exposure));
}

double path_tolerance_px(const Scene& scene) {
  return scene.motion.tolerance_px > 0.0 ? scene.motion.tolerance_px : 0.1;
}

}  // namespace swept
