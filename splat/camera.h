// Rigid and similarity tracks, and the camera: a pinhole, or orthographic.
//
// Camera space everywhere in Swept: x right, y down, z forward, so depth is z and a pixel's ray is
// ((x + ½ − cx)/fx, (y + ½ − cy)/fy, 1) with x, y counted from the top left. Files may say OpenGL
// axes (x right, y up, z backward); the reader converts. An orthographic camera's rays are all (0, 0, 1), and
// begin at ((x + ½ − cx)/fx, (y + ½ − cy)/fy, 0).
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "splat/export.h"
#include "splat/exposure.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// One key of an object's motion: x ↦ translate + rotate(scale · x).
///
/// The rotation is an axis and an angle, so that one key to the next may turn by more than half a
/// revolution: keys that share an axis interpolate the angle, others take the shorter arc (slerp).
struct TransformKey {
  double frame = 0.0;
  Eigen::Vector3d translate = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotate_axis = Eigen::Vector3d::UnitY();  ///< unit length
  double rotate_radians = 0.0;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

/// Keys at strictly increasing frames, interpolated linearly and held outside; empty: identity.
struct TransformTrack {
  std::vector<TransformKey> keys;

  [[nodiscard]] Eigen::Affine3d at(double frame) const;
  /// Whether `at` returns the same bits for every time in [first, last].
  [[nodiscard]] bool constant_over(double first, double last) const;
};

/// What a lens has besides its field of view. Nothing here depends on the film's pixel count.
struct Lens {
  double stretch_x =
      1.0;  ///< focal length in px along x to that along y, 1e-3 to 1e3; not 1: pixels are not square
  /// Principal point, where the view direction meets the film, from the film's middle: x right, y down, in
  /// heights of the film, −1000 to 1000.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double focus = 0.0;  ///< depth that is in focus, world units; 0: not given, which only a pinhole may have

  friend bool operator==(const Lens& a, const Lens& b) {
    return a.stretch_x == b.stretch_x && a.shift == b.shift && a.focus == b.focus;
  }
};

/// The opening that light comes in through: a disc, or a regular polygon within it.
struct Aperture {
  double radius = 0.0;  ///< of the disc, world units; 0: a pinhole, with everything in focus
  int blades = 0;       ///< corners of the polygon, 3 to 64; 0: a disc
  double rotation_radians =
      0.0;          ///< of the polygon's first corner from the camera's x axis towards its y axis
  int samples = 0;  ///< points of the lens to look through, up to 4096; 0: the renderer chooses
};

/// One key of the camera: a pose and a lens. The focal length is a tangent, so that it does not depend on
/// the film's pixel count.
struct CameraKey {
  double frame = 0.0;
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();             ///< world space
  Eigen::Quaterniond world_from_camera{1.0, 0.0, 0.0, 0.0};  ///< unit; camera axes as above
  /// Half the film's height to the focal length along y; of an orthographic camera half the height of what it
  /// sees, world units.
  double tan_half_fov_y = 0.5;
  Lens lens{};
};

/// One key of a camera that looks at a target. Between look-ats eye, target, up and roll are interpolated,
/// and the basis is built at each instant, so that a target stays on the principal point. (Between CameraKeys
/// eye and orientation are interpolated, the latter by slerp.)
struct LookAtKey {
  double frame = 0.0;
  Eigen::Vector3d eye{0.0, 0.0, 5.0}, target{0.0, 0.0, 0.0}, up{0.0, 1.0, 0.0};
  double tan_half_fov_y = 0.5;  ///< as a CameraKey has it
  double roll_radians =
      0.0;  ///< clockwise about the view direction, as seen along it; the picture turns against it
  Lens lens{};
};

/// The camera at one instant.
///
/// Far from the origin, take camera_from_world.linear() * (p - eye): the translation is the difference of
/// two large numbers there, and has lost the digits that p - eye keeps.
struct CameraInstant {
  Eigen::Affine3d camera_from_world;  ///< rigid; translation() == -linear() * eye
  /// World space. For an orthographic camera, the point of the film's middle at depth 0, which includes the
  /// shift of the principal point; lens.shift is 0 then.
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();
  double tan_half_fov_y = 0.5;  ///< as a CameraKey has it
  Lens lens{};
  bool orthographic = false;
};

/// The camera over time. Exactly one of the two lists of keys is non-empty, at strictly increasing frames.
/// Before the first key and after the last the camera is held.
struct CameraTrack {
  std::vector<CameraKey> poses;
  std::vector<LookAtKey> look_ats;
  double near = 1e-3;  ///< world units, > 0: what is nearer is not seen
  /// All rays are parallel, and what is seen has the same size at any depth. There is no lens then.
  bool orthographic = false;
  Aperture aperture{};
  /// The point of the lens that at() looks through, from its middle along the camera's x and y axes, world
  /// units. What is in focus stays where it is on the film.
  Eigen::Vector2d lens_point = Eigen::Vector2d::Zero();

  [[nodiscard]] CameraInstant at(double frame) const;
  [[nodiscard]] bool constant_over(double first, double last) const;
  /// Errors: singular bases (eye on target, up along the view), fields of view out of range, unsorted keys.
  [[nodiscard]] Status validate() const;

 private:
  [[nodiscard]] CameraInstant pinhole_at(double frame) const;
  [[nodiscard]] CameraInstant orthographic_at(double frame) const;
};

/// Film resolution and the window of it to compute.
struct Film {
  int width = 1024, height = 576;                               ///< px, ≥ 1
  int crop_x = 0, crop_y = 0, crop_width = 0, crop_height = 0;  ///< px; width 0: the whole film
  /// Pixels beyond the film's edges that are also computed; only without a crop.
  int overscan_left = 0, overscan_top = 0, overscan_right = 0, overscan_bottom = 0;

  [[nodiscard]] bool has_overscan() const {
    return overscan_left > 0 || overscan_top > 0 || overscan_right > 0 || overscan_bottom > 0;
  }
  [[nodiscard]] int window_x() const { return crop_x - overscan_left; }
  [[nodiscard]] int window_y() const { return crop_y - overscan_top; }
  [[nodiscard]] int window_width() const {
    return crop_width > 0 ? crop_width : width + overscan_left + overscan_right;
  }
  [[nodiscard]] int window_height() const {
    return crop_height > 0 ? crop_height : height + overscan_top + overscan_bottom;
  }
};

/// Pixel coordinates from camera-space directions: x_px = center_x + focal_px · x/z, and the same in
/// y. Pixel (i, j) covers [i, i+1) × [j, j+1) of the whole film; its centre is at i + ½, j + ½.
///
/// There is one focal length. Where a lens has two, camera space is stretched along x before it is
/// projected, by Lens::stretch_x: a plane stays a plane, and a disc an elliptical one. An orthographic camera
/// has x_px = center_x + focal_px · x, focal_px being pixels per world unit.
struct Projection {
  double focal_px = 1.0, center_x = 0.0, center_y = 0.0;
  bool orthographic = false;

  /// What x and y of a point at depth z are divided by.
  [[nodiscard]] double divisor(double z) const { return orthographic ? 1.0 : z; }
};
[[nodiscard]] Projection projection_of(const Film& film, double tan_half_fov_y, const Lens& lens = {});
[[nodiscard]] inline Projection projection_of(const Film& film, const CameraInstant& camera) {
  Projection projection = projection_of(film, camera.tan_half_fov_y, camera.lens);
  projection.orthographic = camera.orthographic;
  return projection;
}

/// The map from the camera space of `camera` to one in which the projection of `reference` shows what
/// `camera` sees: depths stay, x and y are scaled and sheared along the depth. The identity if both have the
/// same lens and focal length.
[[nodiscard]] Eigen::Matrix3d lens_matrix(const CameraInstant& camera, const CameraInstant& reference);

/// The largest |x/z| (axis 0) or |y/z| (axis 1) on the film, or, if the principal point is beside the film,
/// between that point and the film's far edge. For an orthographic camera the largest |x| or |y|.
[[nodiscard]] double largest_tangent(const Film& film, const Projection& projection, int axis);

}  // namespace swept
