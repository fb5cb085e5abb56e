#include "tools/study/variant.h"

#include <algorithm>
#include <variant>
#include <vector>

#include "datasets/generators.h"
#include "splat/image.h"
#include "splat/kernel/kernel_set.h"

namespace swept {
namespace {

/// Motion of the centres that are on the film at one end of the exposure at least.
std::vector<double> motions_px(Scene scene) {
  // One segment: its velocity is the whole way.
  scene.model.segments = 1;
  for (Object& object : scene.objects) object.segments = 1;
  const KernelSet set = build_kernels(scene);
  const auto place = [&](const MovingKernel& kernel, double tau) -> Eigen::Vector2d {
    const Eigen::Vector3d p = kernel.center + (tau - 0.5) * kernel.velocity;
    const double divisor = set.projection.divisor(p.z());
    return {set.projection.center_x + set.projection.focal_px * p.x() / divisor,
            set.projection.center_y + set.projection.focal_px * p.y() / divisor};
  };
  const auto on_film = [&](const Eigen::Vector2d& p) {
    return p.x() >= 0.0 && p.y() >= 0.0 && p.x() <= scene.film.width && p.y() <= scene.film.height;
  };
  std::vector<double> motions;
  for (const MovingKernel& kernel : set.kernels) {
    if (kernel.center.z() - 0.5 * std::abs(kernel.velocity.z()) < set.near) continue;
    const Eigen::Vector2d open = place(kernel, 0.0), close = place(kernel, 1.0);
    if (on_film(open) || on_film(close)) motions.push_back((close - open).norm());
  }
  std::sort(motions.begin(), motions.end());
  return motions;
}

}  // namespace

Result<SceneFile> open_variant(const Variant& variant) {
  SceneOverrides overrides;
  if (variant.size[0] > 0) {
    overrides.fields["/film/width"] = {static_cast<double>(variant.size[0])};
    overrides.fields["/film/height"] = {static_cast<double>(variant.size[1])};
  }
  overrides.points_scale = variant.points_scale;
  if (variant.exposure_scale != 1.0) {
    const Result<SceneFile> plain = read_scene_file(variant.file);
    if (!plain) return plain.error();
    const Shutter shutter = plain->scene().shutter;
    const double middle = 0.5 * (shutter.open + shutter.close);
    const double half = 0.5 * (shutter.close - shutter.open) * variant.exposure_scale;
    overrides.fields["/shutter/open"] = {middle - half};
    overrides.fields["/shutter/close"] = {middle + half};
  }
  return read_scene_file(variant.file, overrides);
}

Result<VariantFacts> facts_of(const Variant& variant) {
  Result<SceneFile> file = open_variant(variant);
  if (!file) return file.error();
  const Result<const Scene*> scene = file->scene_at(file->scene().frame, generate);
  if (!scene) return scene.error();
  VariantFacts facts;
  for (const Object& object : (*scene)->objects) facts.points += object.cloud.size();
  const Image window = blank_image((*scene)->film);
  facts.width = window.width;
  facts.height = window.height;
  Result<std::string> hash = file->hash(file->scene().frame);
  if (!hash) return hash.error();
  facts.hash = std::move(*hash);
  facts.scalable = std::all_of(
      file->sources().begin(), file->sources().end(),
      [](const ObjectSource& source) { return std::holds_alternative<GeneratorSource>(source.points); });
  const std::vector<double> motions = motions_px(**scene);
  if (!motions.empty()) {
    facts.motion_median_px = motions[motions.size() / 2];
    facts.motion_largest_px = motions.back();
  }
  return facts;
}

}  // namespace swept
