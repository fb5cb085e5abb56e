#include "tools/unused_members.h"

#include <algorithm>
#include <string_view>
#include <variant>

#include "splat/fields.h"
#include "splat/io/point_file.h"
#include "splat/io/splat_file.h"
#include "splat/motion/instant.h"
#include "tools/unused_options.h"

namespace swept {
namespace {

class Judge {
 public:
  Judge(const SceneOverrides& given, const SceneFile& file, const Scene& scene)
      : given_(given), file_(file), scene_(scene) {}

  std::vector<UnusedMember> members() {
    fields();
    if (given_.camera_file.empty()) camera_keys();
    if (!given_.camera.any()) lens();
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) object(i);
    return std::move(unused_);
  }

 private:
  [[nodiscard]] std::size_t count(const std::string& pointer) const {
    const auto found = file_.members().find(pointer);
    return found == file_.members().end() ? 0 : found->second;
  }
  void tell(const std::string& pointer, std::string_view reason) {
    if (count(pointer) > 0) unused_.push_back({pointer, std::string(reason)});
  }
  void tell_as(const std::string& pointer, const std::string& option) {
    if (const auto reason = why_unused(option, file_, scene_)) tell(pointer, *reason);
  }

  void fields() {
    static const Scene defaults;
    for (const Field& field : scene_fields()) {
      const std::string pointer(field.pointer);
      if (given_.fields.contains(pointer) || field.get(scene_) == field.get(defaults)) continue;
      tell_as(pointer, std::string(field.option));
    }
    const auto& objects = scene_.objects;
    if (!objects.empty() && !given_.fields.contains("/image/segments") &&
        std::all_of(objects.begin(), objects.end(), [](const Object& o) { return o.segments > 0; }))
      tell("/image/segments", "all objects name their own");
  }

  /// Of keys, those that the exposure is beyond.
  void keys(const std::string& pointer, std::size_t number, double first, double last) {
    if (number < 2) return;
    const Exposure all = scene_.exposure().of_all_rows(scene_.film.height);
    const bool before = all.close <= first, after = all.open >= last;
    if (count(pointer) == 0 || (!before && !after)) return;
    unused_.push_back({pointer,
                       before ? "the exposure is before the first of them, which holds until then"
                              : "the exposure is after the last of them, which holds from then on",
                       true});
  }

  void camera_keys() {
    const CameraTrack& camera = scene_.camera;
    const std::string all = "/camera/keys";
    const auto& poses = camera.poses;
    const auto& look_ats = camera.look_ats;
    if (!poses.empty()) keys(all, poses.size(), poses.front().frame, poses.back().frame);
    if (!look_ats.empty()) keys(all, look_ats.size(), look_ats.front().frame, look_ats.back().frame);
    const std::string each = all + "/*/";
    const std::size_t views = count(each + "fov") + count(each + "intrinsics") + count(each + "height");
    for (const char* view : {"/camera/fov", "/camera/intrinsics", "/camera/height"})
      if (views == count(all)) tell(view, "each key has a view of its own");
    if (count(each + "focus") == count(all)) tell("/camera/lens/focus", "each key has one of its own");
  }

  void lens() {
    const Aperture& aperture = scene_.camera.aperture;
    if (aperture.radius == 0.0) {
      for (const char* member : {"/camera/lens/focus", "/camera/lens/blades", "/camera/lens/rotation",
                                 "/camera/lens/samples", "/camera/keys/*/focus"})
        tell(member, "the lens's opening is 0 wide: all is in focus");
      return;
    }
    if (aperture.rotation_radians != 0.0) tell_as("/camera/lens/rotation", "--lens-rotation");
  }

  void object(std::size_t i) {
    const Object& object = scene_.objects[i];
    const ObjectSource& source = file_.sources()[i];
    const std::string at = source.pointer;
    const auto& transform = object.transform.keys;
    if (!transform.empty())
      keys(at + "/transform/keys", transform.size(), transform.front().frame, transform.back().frame);
    if (object.cloud.size() + object.splats.size() == 0) return;
    const SurfelCloud& cloud = object.cloud;
    const bool rates = !cloud.velocity.empty() || !cloud.acceleration.empty() ||
                       !cloud.angular_velocity.empty() || !object.splats.velocity.empty();
    const bool generated = std::holds_alternative<GeneratorSource>(source.points);
    if (!generated && source.velocity == VelocityUnit::per_frame && !rates)
      tell(at + "/velocity/unit", "nothing of it moves by velocities");
    const auto* file = std::get_if<FileSource>(&source.points);
    if (file != nullptr && file->end_path.empty() && !rates && !source.stamps && !object.splats.motion)
      tell(at + "/source/frame", "nothing of it moves by itself");
    if (source.stamps && !rates && source.stamps->sensor.keys.size() < 2)
      tell(at + "/stamps", "neither its points nor a sensor moves");
    if (!given_.fields.contains("/image/segments")) segments(object, at + "/segments");
    attributes(source, cloud, at);
  }

  void segments(const Object& object, const std::string& pointer) {
    if (object.discs() == 0)
      tell(pointer, "it is not drawn as discs");
    else if (!scene_.exposure().instant() && stands_still(scene_, object, scene_.exposure()))
      tell(pointer, "it does not move while the shutter is open");
    else
      tell_as(pointer, "--segments");
  }

  /// Of the file, what the object replaces or what needs another member.
  void attributes(const ObjectSource& source, const SurfelCloud& cloud, const std::string& at) {
    const std::string in_file = at + "/source/", names = in_file + "attributes/";
    for (const char* stored : {"color_range", "color_space"}) {
      if (source.color || source.color_by_normals)
        tell(in_file + stored, "the object's color replaces those of the file");
      else if (cloud.size() > 0 && cloud.color.empty())
        tell(in_file + stored, "the file has no colours");
    }
    if (source.color || source.color_by_normals)
      tell(names + "intensity", "the object's color replaces those of the file");
    if (source.radius)
      for (const char* size : {"radius", "width"})
        tell(names + size, "the object's radius replaces those of the file");
    if (source.velocity == VelocityUnit::ignore)
      for (const char* rate : {"velocity", "acceleration", "angular_velocity"})
        tell(names + rate, "\"velocity\" has them ignored");
    if (!source.stamps) tell(names + "time", "there are no \"stamps\", which make use of it");
  }

  const SceneOverrides& given_;
  const SceneFile& file_;
  const Scene& scene_;
  std::vector<UnusedMember> unused_;
};

}  // namespace

std::string UnusedMember::text(const std::string& file) const {
  return file + ": " + pointer + (but_one ? " but for one change nothing: " : " changes nothing: ") + reason;
}

std::vector<UnusedMember> unused_members(const SceneOverrides& given, const SceneFile& file,
                                         const Scene& scene) {
  // A scene that was made for points has no file that anyone could mend.
  if (is_point_file_name(file.path()) || is_splat_file_name(file.path())) return {};
  return Judge(given, file, scene).members();
}

std::vector<std::string> RunMembers::of_frame(const std::vector<UnusedMember>& members,
                                              const std::string& file) {
  std::vector<std::string> texts;
  for (const UnusedMember& member : members) texts.push_back(member.text(file));
  if (!first_)
    std::erase_if(texts, [&](const std::string& text) {
      return std::find(common_.begin(), common_.end(), text) == common_.end();
    });
  first_ = false;
  common_ = std::move(texts);
  if (left_ > 0) --left_;
  return left_ == 0 ? common_ : std::vector<std::string>();
}

}  // namespace swept
