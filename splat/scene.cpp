#include "splat/scene.h"

#include <cmath>
#include <string>
#include <utility>

namespace swept {
namespace {

constexpr int max_side_px = 65536;
constexpr int max_segments = 4096;

Error bad(std::string field, std::string reason) { return Error{"", std::move(field), std::move(reason)}; }

/// The same error, with its field seen from the whole scene.
Error within(const std::string& parent, Error error) {
  const bool separate = !error.field.empty() && error.field.front() != '/';
  error.field = parent + (separate ? "/" : "") + error.field;
  return error;
}

Status validate(const Film& film) {
  const std::string size = " must be between 1 and " + std::to_string(max_side_px) + " pixels";
  if (film.width < 1 || film.width > max_side_px) return bad("/film/width", "the width" + size);
  if (film.height < 1 || film.height > max_side_px) return bad("/film/height", "the height" + size);
  if (film.crop_width == 0 && film.crop_height == 0 && film.crop_x == 0 && film.crop_y == 0) return Done{};
  // Differences, not sums, which could overflow.
  if (film.crop_x < 0 || film.crop_width < 1 || film.crop_x > film.width - film.crop_width ||
      film.crop_y < 0 || film.crop_height < 1 || film.crop_y > film.height - film.crop_height)
    return bad("/film/crop", "the crop must be a window of at least one pixel inside the film");
  return Done{};
}

Status validate(const TransformTrack& track) {
  for (std::size_t i = 0; i < track.keys.size(); ++i) {
    const TransformKey& key = track.keys[i];
    const std::string at = "/keys/" + std::to_string(i);
    if (!std::isfinite(key.frame)) return bad(at + "/frame", "the frame is not a finite number");
    if (i > 0 && !(track.keys[i - 1].frame < key.frame))
      return bad(at + "/frame", "keys must be at strictly increasing frames");
    if (!key.translate.allFinite()) return bad(at + "/translate", "the translation is not finite");
    if (!std::isfinite(key.rotate_radians)) return bad(at + "/rotate", "the angle is not a finite number");
    // A rotation matrix is off by twice what its axis is off by; a float's unit axis still passes.
    constexpr double unit_tolerance = 1e-6;
    if (!(std::abs(key.rotate_axis.norm() - 1.0) <= unit_tolerance))
      return bad(at + "/rotate", "the axis is not of unit length");
    if (!key.scale.allFinite()) return bad(at + "/scale", "the scale is not finite");
  }
  return Done{};
}

Status validate(const Object& object) {
  if (Status cloud = object.cloud.validate(); !cloud) return within("/cloud", cloud.error());
  if (Status track = validate(object.transform); !track) return within("/transform", track.error());
  if (object.segments < 0 || object.segments > max_segments)
    return bad("/segments",
               "segments must be between 1 and " + std::to_string(max_segments) + ", or 0 for the image's");
  return Done{};
}

}  // namespace

// Comparisons are written so that NaN fails them.

Status ImageModel::validate() const {
  if (!(delta > 0.0 && delta <= 50.0)) return bad("/delta", "delta must be above 0 and at most 50");
  if (!(filter_radius_px >= 0.0 && filter_radius_px <= 100.0))
    return bad("/filter_radius_px", "the filter radius must be between 0 and 100 pixels");
  if (coverage != Coverage::soft && coverage != Coverage::hard)
    return bad("/coverage", "coverage must be soft or hard");
  if (!(edge_weight > 0.0 && edge_weight <= 1.0))
    return bad("/edge_weight", "the edge weight must be above 0 and at most 1");
  if (!(depth_tolerance >= 0.0 && depth_tolerance <= 100.0))
    return bad("/depth_tolerance", "the depth tolerance must be between 0 and 100");
  if (segments < 0 || segments > max_segments)
    return bad("/segments", "segments must be between 1 and " + std::to_string(max_segments) +
                                ", or 0 to have them chosen");
  return Done{};
}

Status Scene::validate() const {
  if (!std::isfinite(frame)) return bad("/frame", "the frame is not a finite number");
  if (Status status = swept::validate(film); !status) return status;
  if (Status status = camera.validate(); !status) return within("/camera", status.error());
  if (!std::isfinite(shutter.open)) return bad("/shutter/open", "the time is not a finite number");
  if (!std::isfinite(shutter.close)) return bad("/shutter/close", "the time is not a finite number");
  if (shutter.close < shutter.open) return bad("/shutter/close", "the shutter closes before it opens");
  if (fps.numerator < 1 || fps.denominator < 1)
    return bad("/fps", "both terms of the rate must be 1 or more");
  if (!background.allFinite()) return bad("/background", "the background is not finite");
  if (!(background.w() >= 0.0 && background.w() <= 1.0))
    return bad("/background", "the background's alpha must be between 0 and 1");
  if (Status status = model.validate(); !status) return within("/image", status.error());
  for (std::size_t i = 0; i < objects.size(); ++i)
    if (Status status = swept::validate(objects[i]); !status)
      return within("/objects/" + std::to_string(i), status.error());
  return Done{};
}

}  // namespace swept
