// Interpolation of tracks. Whatever two keys share comes out with the bits it went in with, because
// "does not move" is decided by equality: interpolation is a + t (b − a), and rotations that agree are
// not interpolated at all.
#include "splat/camera.h"
#include "splat/without_throwing.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace swept {
namespace {

/// Sine of the angle below which two directions count as parallel: a basis built from them would have
/// lost half of double's digits.
constexpr double parallel_sine = 1e-8;

/// The keys around a time: key = (1 − t) before + t after; before == after where nothing is interpolated.
template <class Key>
struct Bracket {
  const Key* before;
  const Key* after;
  double t;
};

template <class Key>
Bracket<Key> bracket(const std::vector<Key>& keys, double frame) {
  const auto next = std::upper_bound(keys.begin(), keys.end(), frame,
                                     [](double value, const Key& key) { return value < key.frame; });
  if (next == keys.begin()) return {&keys.front(), &keys.front(), 0.0};
  const Key& before = *(next - 1);
  if (next == keys.end() || before.frame == frame) return {&before, &before, 0.0};
  return {&before, &*next, (frame - before.frame) / (next->frame - before.frame)};
}

/// Whether all keys that `at` consults within [first, last] hold the same values.
template <class Key, class Same>
bool constant_between(const std::vector<Key>& keys, double first, double last, Same same) {
  if (keys.empty() || first == last) return true;
  const Key* begin = bracket(keys, first).before;
  const Key* end = bracket(keys, last).after;
  return std::all_of(begin, end + 1, [&](const Key& key) { return same(*begin, key); });
}

template <class T>
T interpolate(const T& a, const T& b, double t) {
  return a + t * (b - a);
}

/// q and −q are one rotation, and give one matrix to the bit.
bool same_rotation(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.coeffs() == b.coeffs() || a.coeffs() == -b.coeffs();
}

bool same_values(const TransformKey& a, const TransformKey& b) {
  return a.translate == b.translate && a.rotate_axis == b.rotate_axis &&
         a.rotate_radians == b.rotate_radians && a.scale == b.scale;
}

bool same_values(const CameraKey& a, const CameraKey& b) {
  return a.eye == b.eye && same_rotation(a.world_from_camera, b.world_from_camera) &&
         a.tan_half_fov_y == b.tan_half_fov_y && a.lens == b.lens;
}

bool same_values(const LookAtKey& a, const LookAtKey& b) {
  return a.eye == b.eye && a.target == b.target && a.up == b.up && a.roll_radians == b.roll_radians &&
         a.tan_half_fov_y == b.tan_half_fov_y && a.lens == b.lens;
}

Lens interpolate(const Lens& a, const Lens& b, double t) {
  return {a.stretch_x + t * (b.stretch_x - a.stretch_x), a.shift + t * (b.shift - a.shift),
          a.focus + t * (b.focus - a.focus)};
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& axis, double radians) {
  return Eigen::AngleAxisd(radians, axis).toRotationMatrix();
}

Eigen::Matrix3d interpolate_rotation(const TransformKey& a, const TransformKey& b, double t) {
  // Axes written as [1,1,0] and [2,2,0] differ by rounding once they are unit length.
  constexpr double same_axis = 1e-12;
  // A rotation by nothing has no axis of its own: it turns about the other's.
  const Eigen::Vector3d& axis = a.rotate_radians == 0.0 ? b.rotate_axis : a.rotate_axis;
  const Eigen::Vector3d& other = b.rotate_radians == 0.0 ? axis : b.rotate_axis;
  if ((axis - other).norm() <= same_axis)
    return rotation(axis, interpolate(a.rotate_radians, b.rotate_radians, t));
  if ((axis + other).norm() <= same_axis)
    return rotation(axis, interpolate(a.rotate_radians, -b.rotate_radians, t));
  const Eigen::Quaterniond from(Eigen::AngleAxisd(a.rotate_radians, a.rotate_axis));
  const Eigen::Quaterniond to(Eigen::AngleAxisd(b.rotate_radians, b.rotate_axis));
  return from.slerp(t, to).normalized().toRotationMatrix();
}

/// Adding zero turns −0 into +0, so that keys that compare equal give equal bits.
Eigen::Affine3d assemble(const Eigen::Vector3d& translate, const Eigen::Matrix3d& rotate,
                         const Eigen::Vector3d& scale) {
  Eigen::Affine3d result = Eigen::Affine3d::Identity();
  result.linear() = (rotate * scale.asDiagonal()).array() + 0.0;
  result.translation() = translate.array() + 0.0;
  return result;
}

CameraInstant instant(const Eigen::Vector3d& eye, const Eigen::Matrix3d& camera_from_world,
                      double tan_half_fov_y, const Lens& lens) {
  CameraInstant result;
  result.camera_from_world = Eigen::Affine3d::Identity();
  result.camera_from_world.linear() = camera_from_world.array() + 0.0;
  result.camera_from_world.translation() = (-(camera_from_world * eye)).array() + 0.0;
  result.eye = eye.array() + 0.0;
  result.tan_half_fov_y = tan_half_fov_y;
  result.lens = lens;
  return result;
}

/// Of unit length, whatever the length of `v`: squares beyond 1e154 or below 1e-154 are no numbers.
Eigen::Vector3d direction(const Eigen::Vector3d& v) {
  const double square = v.squaredNorm();
  return square > 1e-290 && square < 1e290 ? v.normalized() : v.stableNormalized();
}

/// Rows are the camera's axes: right, down and forward.
Eigen::Matrix3d look_at_basis(const Eigen::Vector3d& view, const Eigen::Vector3d& up, double roll_radians) {
  const Eigen::Vector3d forward = direction(view);
  const Eigen::Vector3d right = direction(forward.cross(up));
  Eigen::Matrix3d basis;
  basis << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  if (roll_radians == 0.0) return basis;
  const double cosine = std::cos(roll_radians), sine = std::sin(roll_radians);
  const Eigen::RowVector3d level = basis.row(0), down = basis.row(1);
  basis.row(0) = cosine * level + sine * down;
  basis.row(1) = cosine * down - sine * level;
  return basis;
}

Error bad(std::size_t key, const char* member, std::string reason) {
  return Error{"", "/keys/" + std::to_string(key) + member, std::move(reason)};
}

/// What both kinds of key have: frame, eye and field of view.
template <class Key>
Status validate_common(const std::vector<Key>& keys, std::size_t i, bool orthographic) {
  const Key& key = keys[i];
  if (!(std::abs(key.frame) <= most_frame)) return bad(i, "/frame", "the frame must be between -1e9 and 1e9");
  if (i > 0 && !(keys[i - 1].frame < key.frame))
    return bad(i, "/frame", "keys must be at strictly increasing frames");
  if (!key.eye.allFinite()) return bad(i, "/eye", "the eye is not finite");
  if (!(key.tan_half_fov_y > 0.0) || !std::isfinite(key.tan_half_fov_y))
    return bad(i, orthographic ? "/height" : "/fov",
               orthographic ? "the height must be above 0 and finite"
                            : "the field of view must be above 0 and below 180 degrees");
  constexpr double most_stretch = 1e3, most_shift = 1e3;
  if (!(key.lens.stretch_x >= 1.0 / most_stretch && key.lens.stretch_x <= most_stretch))
    return bad(i, "/intrinsics/fx", "one focal length must be at most 1000 times the other");
  for (int axis = 0; axis < 2; ++axis)
    if (!(std::abs(key.lens.shift[axis]) <= most_shift))
      return bad(i, axis == 0 ? "/intrinsics/cx" : "/intrinsics/cy",
                 "the principal point must be within 1000 heights of the film's middle");
  return Done{};
}

/// Both not zero.
bool parallel(const Eigen::Vector3d& view, const Eigen::Vector3d& up) {
  return !(view.stableNormalized().cross(up.stableNormalized()).norm() > parallel_sine);
}

/// Whether the basis vanishes somewhere between two good keys. View and up are linear in t there, so their
/// product is quadratic, and where it is zero each component has a root.
bool singular_between(const LookAtKey& a, const LookAtKey& b) {
  // In units of the largest of its coordinates each, so that no product leaves the range of a double.
  const Eigen::Vector3d view_a = a.target - a.eye, view_b = b.target - b.eye;
  const double view_unit = std::max(view_a.cwiseAbs().maxCoeff(), view_b.cwiseAbs().maxCoeff());
  const double up_unit = std::max(a.up.cwiseAbs().maxCoeff(), b.up.cwiseAbs().maxCoeff());
  const Eigen::Vector3d view = view_a / view_unit, view_step = view_b / view_unit - view;
  const Eigen::Vector3d up = a.up / up_unit, up_step = b.up / up_unit - up;
  const Eigen::Vector3d c0 = view.cross(up), c2 = view_step.cross(up_step);
  const Eigen::Vector3d c1 = view.cross(up_step) + view_step.cross(up);
  const auto singular_at = [&](double t) {
    if (!(t > 0.0 && t < 1.0)) return false;
    const Eigen::Vector3d view_t = view + t * view_step, up_t = up + t * up_step;
    // A step through the target leaves a rounding error for a view, whose direction means nothing.
    constexpr double lost = 1e-12;
    if (view_t.norm() <= lost * view_step.norm() || up_t.norm() <= lost * up_step.norm()) return true;
    return parallel(view_t, up_t);
  };
  for (int i = 0; i < 3; ++i) {
    const double discriminant = std::max(0.0, c1[i] * c1[i] - 4.0 * c2[i] * c0[i]);
    const double q = -0.5 * (c1[i] + std::copysign(std::sqrt(discriminant), c1[i]));
    // The vertex stands in for a double root whose discriminant rounded below zero.
    for (const double t : {q / c2[i], c0[i] / q, -0.5 * c1[i] / c2[i]})
      if (singular_at(t)) return true;
  }
  return false;
}

Status validate_look_ats(const std::vector<LookAtKey>& keys, bool orthographic) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (Status common = validate_common(keys, i, orthographic); !common) return common;
    const LookAtKey& key = keys[i];
    if (!key.target.allFinite()) return bad(i, "/target", "the target is not finite");
    if (!key.up.allFinite()) return bad(i, "/up", "the up vector is not finite");
    constexpr double most_roll = 1e6;
    if (!(std::abs(key.roll_radians) <= most_roll))
      return bad(i, "/roll", "the roll must be within a million radians");
    const Eigen::Vector3d view = key.target - key.eye;
    if (!view.allFinite()) return bad(i, "/target", "the target is too far from the eye for a double");
    if (view.isZero(0.0)) return bad(i, "/target", "the target is where the eye is");
    if (key.up.isZero(0.0)) return bad(i, "/up", "the up vector is zero");
    if (parallel(view, key.up)) return bad(i, "/up", "the up vector is parallel to the view direction");
    if (i > 0 && singular_between(keys[i - 1], key))
      return bad(i, "",
                 "between this key and the one before it the eye meets the target or up meets the view "
                 "direction; add a key between them");
  }
  return Done{};
}

Status validate_aperture(const Aperture& aperture) {
  if (!(aperture.radius >= 0.0 && aperture.radius <= 1e9))
    return Error{"", "/lens/aperture", "must be between 0 and 2e9 world units"};
  if (aperture.blades != 0 && !(aperture.blades >= 3 && aperture.blades <= 64))
    return Error{"", "/lens/blades", "must be between 3 and 64"};
  if (!std::isfinite(aperture.rotation_radians))
    return Error{"", "/lens/rotation", "the angle is not a finite number"};
  if (aperture.samples < 0 || aperture.samples > 4096)
    return Error{"", "/lens/samples", "must be between 1 and 4096, or 0 to have them chosen"};
  return Done{};
}

/// Of a camera with a lens.
template <class Key>
Status validate_focus(const std::vector<Key>& keys) {
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (!(keys[i].lens.focus > 0.0) || !std::isfinite(keys[i].lens.focus))
      return bad(i, "/focus", "a lens needs the distance that is in focus, a finite number above 0");
  return Done{};
}

Status validate_poses(const std::vector<CameraKey>& keys, bool orthographic) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (Status common = validate_common(keys, i, orthographic); !common) return common;
    // Slerp and the conversion to a matrix assume unit length; the error of both is that of the norm.
    constexpr double unit_tolerance = 1e-9;
    if (!(std::abs(keys[i].world_from_camera.norm() - 1.0) <= unit_tolerance))
      return bad(i, "/matrix", "the orientation is not a unit quaternion");
  }
  return Done{};
}

}  // namespace

Eigen::Affine3d TransformTrack::at(double frame) const {
  if (keys.empty()) return Eigen::Affine3d::Identity();
  const auto [a, b, t] = bracket(keys, frame);
  if (a == b || same_values(*a, *b))
    return assemble(a->translate, rotation(a->rotate_axis, a->rotate_radians), a->scale);
  return assemble(interpolate(a->translate, b->translate, t), interpolate_rotation(*a, *b, t),
                  interpolate(a->scale, b->scale, t));
}

bool TransformTrack::constant_over(double first, double last) const {
  return constant_between(keys, first, last,
                          [](const TransformKey& a, const TransformKey& b) { return same_values(a, b); });
}

CameraInstant CameraTrack::orthographic_at(double frame) const {
  CameraInstant camera = pinhole_at(frame);
  camera.orthographic = true;
  if (camera.lens.shift.isZero(0.0)) return camera;
  // The film's middle sees what the principal point's shift is away from. A film's height is 2
  // tan_half_fov_y.
  const Eigen::Vector2d aside = -2.0 * camera.tan_half_fov_y * camera.lens.shift;
  const Eigen::Matrix3d rotation = camera.camera_from_world.linear();
  camera.eye += rotation.transpose() * Eigen::Vector3d(aside.x() / camera.lens.stretch_x, aside.y(), 0.0);
  camera.camera_from_world.translation() = -(rotation * camera.eye);
  camera.lens.shift.setZero();
  return camera;
}

CameraInstant CameraTrack::at(double frame) const {
  if (orthographic) return orthographic_at(frame);
  CameraInstant camera = pinhole_at(frame);
  if (lens_point.isZero(0.0)) return camera;
  // With p the point and F the focus a point (x, y, z) is seen at (x − p)/z + p/F: from a moved eye, with a
  // moved principal point. A film's height is 2 tan_half_fov_y at depth 1.
  const Eigen::Matrix3d rotation = camera.camera_from_world.linear();
  camera.eye += rotation.transpose() * Eigen::Vector3d(lens_point.x(), lens_point.y(), 0.0);
  camera.camera_from_world.translation() = -(rotation * camera.eye);
  const double heights = 1.0 / (2.0 * camera.tan_half_fov_y * camera.lens.focus);
  camera.lens.shift += heights * Eigen::Vector2d(camera.lens.stretch_x * lens_point.x(), lens_point.y());
  return camera;
}

CameraInstant CameraTrack::pinhole_at(double frame) const {
  if (!poses.empty()) {
    const auto [a, b, t] = bracket(poses, frame);
    const Eigen::Quaterniond orientation =
        a == b || same_rotation(a->world_from_camera, b->world_from_camera)
            ? a->world_from_camera
            : a->world_from_camera.slerp(t, b->world_from_camera).normalized();
    return instant(interpolate(a->eye, b->eye, t), orientation.toRotationMatrix().transpose(),
                   interpolate(a->tan_half_fov_y, b->tan_half_fov_y, t), interpolate(a->lens, b->lens, t));
  }
  if (look_ats.empty()) {
    const LookAtKey key;
    return instant(key.eye, look_at_basis(key.target - key.eye, key.up, 0.0), key.tan_half_fov_y, key.lens);
  }
  const auto [a, b, t] = bracket(look_ats, frame);
  const Eigen::Vector3d eye = interpolate(a->eye, b->eye, t);
  const Eigen::Vector3d target = interpolate(a->target, b->target, t);
  const double roll = interpolate(a->roll_radians, b->roll_radians, t);
  return instant(eye, look_at_basis(target - eye, interpolate(a->up, b->up, t), roll),
                 interpolate(a->tan_half_fov_y, b->tan_half_fov_y, t), interpolate(a->lens, b->lens, t));
}

bool CameraTrack::constant_over(double first, double last) const {
  const auto same = [](const auto& a, const auto& b) { return same_values(a, b); };
  return poses.empty() ? constant_between(look_ats, first, last, same)
                       : constant_between(poses, first, last, same);
}

Status CameraTrack::validate() const {
  return without_throwing("to check the camera", [&]() -> Status {
    if (poses.empty() == look_ats.empty())
      return Error{"", "/keys", "a camera needs keys of one kind: poses or look-ats"};
    if (!(near > 0.0) || !std::isfinite(near))
      return Error{"", "/near", "the near distance must be a finite number above 0"};
    if (Status status = validate_aperture(aperture); !status) return status;
    if (orthographic && (aperture.radius > 0.0 || !lens_point.isZero(0.0)))
      return Error{"", "/lens", "an orthographic camera has no lens: its rays are parallel",
                   ErrorKind::unsupported};
    if (!lens_point.allFinite()) return Error{"", "/lens", "the point on the lens is not finite"};
    if (aperture.radius > 0.0 || !lens_point.isZero(0.0)) {
      if (Status status = poses.empty() ? validate_focus(look_ats) : validate_focus(poses); !status)
        return status;
    }
    return poses.empty() ? validate_look_ats(look_ats, orthographic) : validate_poses(poses, orthographic);
  });
}

Projection projection_of(const Film& film, double tan_half_fov_y, const Lens& lens) {
  return {0.5 * film.height / tan_half_fov_y, 0.5 * film.width + film.height * lens.shift.x(),
          0.5 * film.height + film.height * lens.shift.y()};
}

Eigen::Matrix3d lens_matrix(const CameraInstant& camera, const CameraInstant& reference) {
  const double zoom = reference.tan_half_fov_y / camera.tan_half_fov_y;
  // A film's height is 2 tan_half_fov_y at depth 1.
  const Eigen::Vector2d shear = 2.0 * reference.tan_half_fov_y * (camera.lens.shift - reference.lens.shift);
  Eigen::Matrix3d matrix;
  matrix << zoom * camera.lens.stretch_x, 0.0, shear.x(), 0.0, zoom, shear.y(), 0.0, 0.0, 1.0;
  return matrix;
}

double largest_tangent(const Film& film, const Projection& projection, int axis) {
  const double center = axis == 0 ? projection.center_x : projection.center_y;
  return std::max(center, (axis == 0 ? film.width : film.height) - center) / projection.focal_px;
}

}  // namespace swept
