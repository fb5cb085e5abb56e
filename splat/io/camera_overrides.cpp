// What a caller wants of a scene's camera otherwise than the scene says.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "splat/io/scene_parsing.h"

namespace swept::io {
namespace {

[[noreturn]] void refuse(const std::string& file, const char* field, const char* reason) {
  throw Error{file, std::string("/camera/") + field, reason, ErrorKind::argument};
}

/// All but the way it looks, and the focus, which is told.
template <class Key>
Key between_but_for_view(const Key& a, const Key& b, double t) {
  Key key = a;
  key.eye += t * (b.eye - a.eye);
  key.tan_half_fov_y += t * (b.tan_half_fov_y - a.tan_half_fov_y);
  key.lens.stretch_x += t * (b.lens.stretch_x - a.lens.stretch_x);
  key.lens.shift += t * (b.lens.shift - a.lens.shift);
  return key;
}

LookAtKey between(const LookAtKey& a, const LookAtKey& b, double frame) {
  const double t = (frame - a.frame) / (b.frame - a.frame);
  LookAtKey key = between_but_for_view(a, b, t);
  key.target += t * (b.target - a.target);
  key.up += t * (b.up - a.up);
  key.roll_radians += t * (b.roll_radians - a.roll_radians);
  return key;
}

CameraKey between(const CameraKey& a, const CameraKey& b, double frame) {
  const double t = (frame - a.frame) / (b.frame - a.frame);
  CameraKey key = between_but_for_view(a, b, t);
  key.world_from_camera = a.world_from_camera.slerp(t, b.world_from_camera).normalized();
  return key;
}

/// Linear from key to key and held outside, as all else of a camera is.
double focus_at(const std::vector<CameraOverrides::Focus>& keys, double frame) {
  if (frame <= keys.front().frame) return keys.front().distance;
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (frame <= keys[i].frame) {
      const double t = (frame - keys[i - 1].frame) / (keys[i].frame - keys[i - 1].frame);
      return keys[i - 1].distance + t * (keys[i].distance - keys[i - 1].distance);
    }
  return keys.back().distance;
}

/// Adds keys where the focus has some and the camera has none, which changes nothing of its way.
template <class Key>
void set_focus(const std::vector<CameraOverrides::Focus>& focus, std::vector<Key>& keys) {
  if (keys.empty()) return;
  if (focus.size() > 1) {
    std::vector<Key> all = keys;
    for (const CameraOverrides::Focus& at : focus) {
      const auto next =
          std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return key.frame >= at.frame; });
      if (next != keys.end() && next->frame == at.frame) continue;
      Key key = next == keys.begin() ? keys.front()
                : next == keys.end() ? keys.back()
                                     : between(*(next - 1), *next, at.frame);
      key.frame = at.frame;
      all.push_back(std::move(key));
    }
    std::sort(all.begin(), all.end(), [](const Key& a, const Key& b) { return a.frame < b.frame; });
    keys = std::move(all);
  }
  for (Key& key : keys) key.lens.focus = focus_at(focus, key.frame);
}

void set_height(double height, const std::string& file, CameraTrack& camera) {
  if (!(height >= 0.0) || !std::isfinite(height)) refuse(file, "height", "must be above 0 and finite");
  if (height == 0.0 && !camera.orthographic) {
    if (camera.look_ats.empty())
      refuse(file, "height", "a camera of matrices has no target whose view could be kept: say the height");
    for (LookAtKey& key : camera.look_ats) key.tan_half_fov_y *= (key.target - key.eye).norm();
  }
  if (height > 0.0) {
    for (LookAtKey& key : camera.look_ats) key.tan_half_fov_y = 0.5 * height;
    for (CameraKey& key : camera.poses) key.tan_half_fov_y = 0.5 * height;
  }
  camera.orthographic = true;
}

void set_lens(const CameraOverrides& wanted, const std::string& file, CameraTrack& camera) {
  Aperture& aperture = camera.aperture;
  const bool of_lens = wanted.aperture || wanted.f_number || wanted.focal_length || !wanted.focus.empty() ||
                       wanted.blades || wanted.rotation_degrees || wanted.lens_points;
  if (wanted.no_lens) {
    if (of_lens) refuse(file, "lens", "is switched off, and something else is wanted of it");
    aperture = {};
    return;
  }
  if (!of_lens) return;
  if (wanted.aperture && wanted.f_number) refuse(file, "lens/f_number", "there is an aperture beside it");
  if (wanted.f_number.has_value() != wanted.focal_length.has_value())
    refuse(file, "lens/f_number", "goes with a focal length, in world units");
  const bool had_lens = aperture.radius > 0.0;
  if (wanted.aperture) aperture.radius = 0.5 * *wanted.aperture;
  if (wanted.f_number) {
    if (!(*wanted.f_number > 0.0 && *wanted.focal_length > 0.0))
      refuse(file, "lens/f_number", "must be above 0, and the focal length too");
    aperture.radius = 0.5 * *wanted.focal_length / *wanted.f_number;
  }
  if (!had_lens && !wanted.aperture && !wanted.f_number)
    refuse(file, "lens", "the scene has no lens, and no aperture is given");
  if (wanted.blades) aperture.blades = *wanted.blades;
  if (wanted.rotation_degrees)
    aperture.rotation_radians = *wanted.rotation_degrees * std::numbers::pi / 180.0;
  if (wanted.lens_points) aperture.samples = *wanted.lens_points;
  for (std::size_t i = 0; i < wanted.focus.size(); ++i) {
    const CameraOverrides::Focus& focus = wanted.focus[i];
    if (!(focus.distance > 0.0) || !std::isfinite(focus.distance))
      refuse(file, "lens/focus", "must be a finite number above 0");
    if (!(std::abs(focus.frame) <= most_frame) || (i > 0 && !(wanted.focus[i - 1].frame < focus.frame)))
      refuse(file, "lens/focus", "keys must be at increasing frames between -1e9 and 1e9");
  }
  if (!wanted.focus.empty()) {
    set_focus(wanted.focus, camera.look_ats);
    set_focus(wanted.focus, camera.poses);
  }
  // What a camera looks at is what it is focused on.
  for (LookAtKey& key : camera.look_ats)
    if (key.lens.focus == 0.0) key.lens.focus = (key.target - key.eye).norm();
  for (const CameraKey& key : camera.poses)
    if (key.lens.focus == 0.0 && aperture.radius > 0.0)
      refuse(file, "lens/focus", "a lens of a camera of matrices needs the distance that is in focus");
}

}  // namespace

void override_camera(const CameraOverrides& wanted, const std::string& file, CameraTrack& camera) {
  if (wanted.height) set_height(*wanted.height, file, camera);
  set_lens(wanted, file, camera);
}

}  // namespace swept::io

namespace swept {

std::vector<double> CameraOverrides::numbers() const {
  std::vector<double> all = {no_lens ? 1.0 : 0.0};
  const auto add = [&](const auto& value) {
    all.push_back(value ? 1.0 : 0.0);
    all.push_back(value ? static_cast<double>(*value) : 0.0);
  };
  add(height), add(aperture), add(f_number), add(focal_length);
  add(blades), add(rotation_degrees), add(lens_points);
  for (const Focus& key : focus) {
    all.push_back(key.frame);
    all.push_back(key.distance);
  }
  return all;
}

bool CameraOverrides::any() const {
  const std::vector<double> all = numbers();
  return std::any_of(all.begin(), all.end(), [](double v) { return v != 0.0; });
}

}  // namespace swept
