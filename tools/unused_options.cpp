#include "tools/unused_options.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <variant>

#include "splat/fields.h"
#include "splat/motion/instant.h"

namespace swept {
namespace {

/// What the rules look at.
struct Drawn {
  const SceneFile& file;
  const Scene& scene;
  std::string_view method;  ///< empty: none

  [[nodiscard]] bool any(bool (*holds)(const Object&)) const {
    return std::any_of(scene.objects.begin(), scene.objects.end(), holds);
  }
  [[nodiscard]] bool by(std::string_view name) const { return method == name; }
};

/// A condition without which an option changes nothing, and what is told then.
struct Need {
  bool (*met)(const Drawn&);
  std::string_view otherwise;
};

struct Rule {
  std::string_view option;
  std::vector<Need> needs;  ///< the first that is not met is told
};

bool moves(const Drawn& drawn) {
  return std::any_of(drawn.scene.objects.begin(), drawn.scene.objects.end(), [&](const Object& object) {
    return !stands_still(drawn.scene, object, drawn.scene.exposure());
  });
}

const std::vector<Rule>& rules() {
  const Need discs{[](const Drawn& d) { return d.any([](const Object& o) { return o.discs() > 0; }); },
                   "nothing is drawn as discs"};
  const Need triangles{
      [](const Drawn& d) { return d.any([](const Object& o) { return !o.triangles.empty(); }); },
      "nothing is drawn as triangles"};
  const Need splats{[](const Drawn& d) { return d.any([](const Object& o) { return o.splats.size() > 0; }); },
                    "nothing is drawn as splats"};
  const Need open{[](const Drawn& d) { return !d.scene.exposure().instant(); },
                  "the shutter opens and closes at once"};
  const Need motion{moves, "nothing moves while the shutter is open"};
  const Need soft{[](const Drawn& d) { return d.scene.model.coverage == Coverage::soft; },
                  "hard coverage has no edges to weigh"};
  const Need trapezoid{[](const Drawn& d) { return d.scene.shutter.curve == ShutterShape::trapezoid; },
                       "the shutter's curve is no trapezoid: --shutter-curve trapezoid makes it one"};
  const Need gaussian{[](const Drawn& d) { return d.scene.shutter.curve == ShutterShape::gaussian; },
                      "the shutter's curve is no Gaussian: --shutter-curve gaussian makes it one"};
  const Need table{[](const Drawn& d) { return d.scene.shutter.curve == ShutterShape::table; },
                   "the shutter's curve is no table: --shutter-curve table makes it one"};
  const Need cut{[](const Drawn& d) { return !d.by("sampled") && !d.by("gpu-still"); },
                 "this method cuts no paths: it draws points where they are at each instant"};
  const Need keys{
      [](const Drawn& d) { return d.any([](const Object& o) { return o.cloud.keys.size() > 1; }); },
      "no points are drawn between two files"};
  const Need trained{
      [](const Drawn& d) { return d.any([](const Object& o) { return o.splats.motion.has_value(); }); },
      "no splats are drawn that were trained in motion"};
  const Need generated{[](const Drawn& d) {
                         const auto& sources = d.file.sources();
                         return std::any_of(sources.begin(), sources.end(), [](const ObjectSource& source) {
                           return std::holds_alternative<GeneratorSource>(source.points);
                         });
                       },
                       "no object is generated"};
  const Need corners{[](const Drawn& d) { return d.scene.camera.aperture.blades > 0; },
                     "the lens's opening is round: --blades gives it corners"};
  const Need lens_grid{[](const Drawn& d) { return !d.by("stochastic"); },
                       "this method looks through a point of the lens of its own for each sample"};
  static const std::vector<Rule> rules = {{"--shutter-curve", {open, motion}},
                                          {"--shutter-ramps", {trapezoid, open, motion}},
                                          {"--shutter-delta", {gaussian, open, motion}},
                                          {"--shutter-rates", {table, open, motion}},
                                          {"--row-delay", {motion}},
                                          {"--path", {keys}},
                                          {"--motion-tolerance", {cut, open, motion}},
                                          {"--segments", {cut, discs, open, motion}},
                                          {"--delta", {discs}},
                                          {"--filter-radius", {discs}},
                                          {"--coverage", {discs}},
                                          {"--edge-weight", {discs, soft}},
                                          {"--depth-tolerance", {discs}},
                                          {"--splat-dilation", {splats}},
                                          {"--splat-least-alpha", {splats}},
                                          {"--splat-most-alpha", {splats}},
                                          {"--splat-least-light", {splats}},
                                          {"--splat-near", {splats}},
                                          {"--splat-blending", {splats}},
                                          {"--clip-frames", {trained}},
                                          {"--points-scale", {generated}},
                                          {"--lens-rotation", {corners}},
                                          {"--lens-points", {lens_grid}},
                                          {"--reference-motion", {discs, open, motion}},
                                          {"--tile-bounds", {triangles, open, motion}}};
  return rules;
}

/// The first need that is not met; null: all are.
const Need* unmet(const Rule& rule, const Drawn& drawn) {
  const auto missing =
      std::find_if(rule.needs.begin(), rule.needs.end(), [&](const Need& need) { return !need.met(drawn); });
  return missing == rule.needs.end() ? nullptr : &*missing;
}

/// Of everything in `given`.
std::set<std::string, std::less<>> names_of(const SceneOverrides& given, const MethodChoice* method) {
  std::set<std::string, std::less<>> names;
  for (const Field& field : scene_fields())
    if (given.fields.contains(field.pointer)) names.emplace(field.option);
  if (given.points_scale != 1.0) names.emplace("--points-scale");
  if (given.camera.rotation_degrees) names.emplace("--lens-rotation");
  if (given.camera.lens_points) names.emplace("--lens-points");
  if (method != nullptr)
    for (const std::string& option : method->arguments.options()) names.insert(option);
  return names;
}

}  // namespace

std::optional<std::string> why_unused(std::string_view option, const SceneFile& file, const Scene& scene) {
  const auto rule =
      std::find_if(rules().begin(), rules().end(), [&](const Rule& of) { return of.option == option; });
  if (rule == rules().end()) return std::nullopt;
  const Need* const missing = unmet(*rule, {file, scene, {}});
  return missing == nullptr ? std::nullopt : std::optional<std::string>(missing->otherwise);
}

std::vector<UnusedOption> unused_options(const SceneOverrides& given, const MethodChoice* method,
                                         const SceneFile& file, const Scene& scene) {
  const Drawn drawn{file, scene, method == nullptr ? std::string_view() : method->method};
  const auto names = names_of(given, method);
  std::vector<UnusedOption> unused;
  for (const Rule& rule : rules()) {
    if (!names.contains(rule.option)) continue;
    if (const Need* const missing = unmet(rule, drawn))
      unused.push_back({std::string(rule.option), std::string(missing->otherwise)});
  }
  return unused;
}

std::string unseen_error(const MethodChoice& method, const Scene& scene) {
  const Aperture& lens = scene.camera.aperture;
  if (method.method != "sampled" || method.arguments.given("--samples") || lens.samples == 0 ||
      !(lens.radius > 0.0))
    return {};
  return "the lens is looked through " + std::to_string(lens.samples) +
         " points, as it is said to be, and no error is estimated: without \"samples\" of the lens as many "
         "are "
         "taken as the error asked for takes";
}

std::vector<std::string_view> options_with_needs() {
  std::vector<std::string_view> options;
  for (const Rule& rule : rules()) options.push_back(rule.option);
  return options;
}

}  // namespace swept
