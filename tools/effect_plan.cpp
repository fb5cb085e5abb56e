#include "tools/effect_plan.h"

#include <algorithm>

#include <fmt/core.h>

#include "splat/lens_points.h"
#include "splat/motion/instant.h"
#include "splat/motion/look.h"
#include "splat/motion/segments.h"

namespace swept {
namespace {

std::string reason(const Scene& scene, const Object& object, const Exposure& exposure) {
  if (exposure.instant()) return "the shutter opens and closes at once";
  std::string what;
  const auto add = [&](bool moves, const char* name) {
    if (moves) what += (what.empty() ? "" : ", ") + std::string(name);
  };
  add(object.cloud.moves() || object.splats.moves(), "its points");
  add(looks_change(object.cloud, exposure.open, exposure.close), "its colours");
  add(!object.transform.constant_over(exposure.open, exposure.close), "its transform");
  add(!scene.camera.constant_over(exposure.open, exposure.close), "the camera");
  return what.empty() ? "nothing moves" : what;
}

std::string sides_text(const ObjectPlan& plan) {
  if (plan.splats) return "Gaussian splats";
  if (plan.triangles) return plan.one_sided ? "triangles, the front alone" : "triangles";
  if (plan.one_sided) return "the front alone";
  if (plan.oriented == 0) return "one side: which is front is not known";
  if (plan.oriented == plan.points) return "two sides";
  return fmt::format("two sides of {} of {} points", plan.oriented, plan.points);
}

std::string lens_text(const ObjectPlan& plan) {
  if (plan.lens_points <= 1) return "no lens";
  if (plan.lens_given) return fmt::format("a lens of {} points", plan.lens_points);
  return fmt::format("a lens of as many points as the error takes, or {} where none is asked for",
                     plan.lens_points);
}

}  // namespace

std::string ObjectPlan::text() const {
  std::string moves = fmt::format("{} ({})", motion, why);
  if (motion == "curved") moves += fmt::format(" in {} segments", segments);
  return fmt::format("{}, {}, {}, {}", moves, layered ? "layered" : "opaque", sides_text(*this),
                     lens_text(*this));
}

nlohmann::ordered_json ObjectPlan::json() const {
  return {{"name", name},
          {"motion", motion},
          {"why", why},
          {"segments", segments},
          {"layered", layered},
          {"splats", splats},
          {"triangles", triangles},
          {"sides", splats || triangles ? "none"
                    : one_sided         ? "front"
                    : oriented == 0     ? "one"
                                        : "two"},
          {"points", points},
          {"points_with_sides", oriented},
          {"lens_points", lens_points}};
}

std::vector<ObjectPlan> effect_plan(const Scene& scene) {
  const Exposure exposure = scene.exposure();
  const int lens = lens_point_count(scene);
  std::vector<ObjectPlan> plans;
  for (const Object& object : scene.objects) {
    const SurfelCloud& cloud = object.cloud;
    ObjectPlan plan;
    plan.name = object.name;
    plan.splats = object.splats.size() > 0;
    plan.triangles = !object.triangles.empty();
    plan.points = plan.splats ? object.splats.size() : cloud.size();
    plan.why = reason(scene, object, exposure);
    const bool still = stands_still(scene, object, exposure);
    if (!still && !plan.splats && !plan.triangles) plan.segments = most_segments(scene, object, exposure);
    plan.motion = still ? "still" : plan.segments > 1 ? "curved" : "straight";
    plan.layered = plan.splats || cloud.see_through();
    plan.one_sided = !object.two_sided;
    plan.oriented = static_cast<std::size_t>(
        std::count_if(cloud.oriented.begin(), cloud.oriented.end(), [](auto known) { return known != 0; }));
    plan.lens_points = lens;
    plan.lens_given = scene.camera.aperture.samples > 0;
    plans.push_back(std::move(plan));
  }
  return plans;
}

}  // namespace swept
