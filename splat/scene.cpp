#include "splat/scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "splat/fields.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

Error bad(std::string field, std::string reason) { return Error{"", std::move(field), std::move(reason)}; }
/// Valid, but not for the renderer.
Error refused(std::string field, std::string reason) {
  return Error{"", std::move(field), std::move(reason), ErrorKind::unsupported};
}

/// The same error, with its field seen from the whole scene.
Error within(const std::string& parent, Error error) {
  const bool separate = !error.field.empty() && error.field.front() != '/';
  error.field = parent + (separate ? "/" : "") + error.field;
  return error;
}

Status validate(const TransformTrack& track) {
  for (std::size_t i = 0; i < track.keys.size(); ++i) {
    const TransformKey& key = track.keys[i];
    const std::string at = "/keys/" + std::to_string(i);
    if (!(std::abs(key.frame) <= most_frame))
      return bad(at + "/frame", "the frame must be between -1e9 and 1e9");
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

Status validate_materials(const Object& object) {
  if (object.texture && !object.materials.empty())
    return bad("/materials", "do not go with a texture of all");
  if (object.materials.empty() != object.material_of.empty())
    return bad("/material_of", "goes with materials, and these with it");
  if (!object.materials.empty() && object.material_of.size() != object.triangles.size())
    return bad("/material_of", "must be one for each of the " + std::to_string(object.triangles.size()) +
                                   " triangles; there are " + std::to_string(object.material_of.size()));
  for (std::size_t t = 0; t < object.material_of.size(); ++t)
    if (object.material_of[t] >= object.materials.size())
      return bad("/material_of/" + std::to_string(t), "names material " +
                                                          std::to_string(object.material_of[t]) + " of " +
                                                          std::to_string(object.materials.size()));
  for (std::size_t m = 0; m < object.materials.size(); ++m) {
    const Material& material = object.materials[m];
    const std::string at = "/materials/" + std::to_string(m);
    if (!(material.color.cwiseAbs().maxCoeff() <= most_color))
      return bad(at + "/color", "must be between -1e30 and 1e30");
    if (!(material.opacity >= 0.0f && material.opacity <= 1.0f))
      return bad(at + "/opacity", "must lie in [0, 1]");
    if (material.texture)
      if (Status texture = material.texture->validate(); !texture)
        return within(at + "/texture", texture.error());
  }
  return Done{};
}

bool has_texture(const Object& object) {
  return object.texture || std::any_of(object.materials.begin(), object.materials.end(),
                                       [](const Material& material) { return material.texture != nullptr; });
}

Status validate_texture(const Object& object) {
  if (!has_texture(object))
    return object.texture_corners.empty() ? Status(Done{})
                                          : bad("/texture_corners", "there is no texture for them");
  if (object.triangles.empty()) return bad("/texture", "there are no triangles for it");
  if (object.texture_corners.size() != object.triangles.size())
    return bad("/texture_corners", "must be one for each of the " + std::to_string(object.triangles.size()) +
                                       " triangles; there are " +
                                       std::to_string(object.texture_corners.size()));
  for (std::size_t t = 0; t < object.texture_corners.size(); ++t)
    for (const Eigen::Vector2f& uv : object.texture_corners[t])
      if (!(std::abs(uv.x()) <= most_texture_coordinate && std::abs(uv.y()) <= most_texture_coordinate))
        return bad("/texture_corners/" + std::to_string(t), "must be between -1e6 and 1e6");
  if (object.texture)
    if (Status texture = object.texture->validate(); !texture) return within("/texture", texture.error());
  return Done{};
}

Status validate(const Object& object) {
  if (Status cloud = object.cloud.validate(); !cloud) return within("/cloud", cloud.error());
  if (Status splats = object.splats.validate(); !splats) return within("/splats", splats.error());
  if (object.cloud.size() > 0 && object.splats.size() > 0)
    return bad("/splats", "an object has either points or splats");
  if (!object.triangles.empty() && !object.cloud.lifetime.empty())
    return bad("/triangles",
               "lie between points that come and go; \"draw\": \"surfels\" has discs drawn instead");
  for (std::size_t t = 0; t < object.triangles.size(); ++t)
    for (const std::uint32_t corner : object.triangles[t])
      if (corner >= object.cloud.size())
        return bad("/triangles/" + std::to_string(t),
                   "names point " + std::to_string(corner) + " of " + std::to_string(object.cloud.size()));
  if (Status materials = validate_materials(object); !materials) return materials;
  if (Status texture = validate_texture(object); !texture) return texture;
  if (Status track = validate(object.transform); !track) return within("/transform", track.error());
  if (object.segments < 0 || object.segments > max_segments)
    return bad("/segments",
               "segments must be between 1 and " + std::to_string(max_segments) + ", or 0 for the image's");
  return Done{};
}

}  // namespace

Status ImageModel::validate() const {
  Scene scene;
  scene.model = *this;
  Status status = validate_fields(scene, "/image/");
  if (status) return status;
  const std::string& field = status.error().field;
  return bad(field.substr(field.rfind('/')), status.error().reason);
}

Exposure Scene::exposure() const {
  Exposure exposure{frame + shutter.open, frame + shutter.close};
  exposure.row_delay = shutter.row_delay;
  if (shutter.curve == ShutterShape::box || exposure.instant()) return exposure;
  exposure.curve = std::make_shared<const ShutterCurve>(shutter);
  exposure.curve_open = exposure.open;
  exposure.curve_close = exposure.close;
  return exposure;
}

Status Scene::validate() const {
  return without_throwing("to check the scene", [&]() -> Status {
    // Written so that NaN fails it.
    if (!(std::abs(frame) <= most_frame)) return bad("/frame", "the frame must be between -1e9 and 1e9");
    if (Status status = validate_fields(*this); !status) return status;
    if (Status status = camera.validate(); !status) return within("/camera", status.error());
    for (std::size_t i = 0; i < objects.size(); ++i)
      if (Status status = swept::validate(objects[i]); !status)
        return within("/objects/" + std::to_string(i), status.error());
    return Done{};
  });
}

Status refuse_row_delay(const Scene& scene, std::string_view renderer) {
  if (scene.shutter.row_delay == 0.0) return Done{};
  return refused("/shutter/row_delay",
                 "rows are exposed one after the other, which " + std::string(renderer) + " does not do");
}

Status refuse_orthographic(const Scene& scene, std::string_view renderer) {
  if (!scene.camera.orthographic) return Done{};
  return refused("/camera/height",
                 "the camera is orthographic, which " + std::string(renderer) + " does not do");
}

Status refuse_lifetimes(const Scene& scene, std::string_view renderer) {
  const Exposure exposure = scene.exposure();
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    for (const Lifetime& life : scene.objects[i].cloud.lifetime)
      if (life.born > exposure.open || life.gone <= exposure.close)
        return refused("/objects/" + std::to_string(i),
                       "has points that come or go while the shutter is open, which " +
                           std::string(renderer) + " does not draw");
  return Done{};
}

Status refuse_splats(const Scene& scene, std::string_view renderer) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (scene.objects[i].splats.size() > 0)
      return refused(
          "/objects/" + std::to_string(i),
          "is made of Gaussian splats, which " + std::string(renderer) +
              " does not draw; --method sampled does, and \"draw\": \"surfels\" has them read as discs");
  return Done{};
}

Status refuse_triangles(const Scene& scene, std::string_view renderer) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (!scene.objects[i].triangles.empty())
      return refused("/objects/" + std::to_string(i),
                     "is made of triangles, which " + std::string(renderer) +
                         " does not draw; --method sampled does, and \"draw\": \"surfels\" has its points "
                         "drawn as discs");
  return Done{};
}

}  // namespace swept
