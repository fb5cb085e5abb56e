#include "tools/scene_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <variant>

#include <fmt/core.h>

#include "splat/io/sequence.h"
#include "splat/lens_points.h"
#include "splat/motion/segments.h"
#include "tools/longest_streak.h"

namespace swept {
namespace {

std::string describe(const ObjectSource& source) {
  if (const auto* generator = std::get_if<GeneratorSource>(&source.points))
    return "generator " + generator->shape;
  if (const auto* file = std::get_if<FileSource>(&source.points))
    return file->end_path.empty() ? file->path : file->path + " to " + file->end_path;
  const auto& sequence = std::get<SequenceSource>(source.points);
  std::string text = sequence.pattern;
  if (sequence.first) text += fmt::format(" {}-{}", *sequence.first, *sequence.last);
  if (sequence.step != 1) text += fmt::format("x{}", sequence.step);
  if (!sequence.numbers.empty()) text += ' ' + frame_ranges_text(sequence.numbers);
  if (sequence.offset != 0) text += fmt::format(", {} frames later", sequence.offset);
  return text + (sequence.gaps ? ", with gaps" : "") + (sequence.cycle ? ", cyclic" : "");
}

bool any_moves(const PointArray<Eigen::Vector3f>& velocities) {
  return std::any_of(velocities.begin(), velocities.end(),
                     [](const Eigen::Vector3f& velocity) { return !velocity.isZero(0.0f); });
}

bool points_move(const SurfelCloud& cloud, double open, double close) {
  if (open == close || cloud.size() == 0) return false;
  if (cloud.keys.size() > 1) return open < cloud.keys.back().frame && close > cloud.keys.front().frame;
  return cloud.moves();
}

/// What an object of splats has otherwise than one of discs.
void report_splats(const Object& object, double open, double close, ObjectReport& report) {
  const SplatCloud& splats = object.splats;
  report.points = splats.size();
  report.keys = 1;
  report.splats = true;
  report.points_move = open != close && (splats.motion || any_moves(splats.velocity));
  report.has_opacity = true;
  for (const double frame : {open, open + 0.5 * (close - open), close}) {
    const Eigen::Affine3d world = object.transform.at(frame);
    for (std::size_t i = 0; i < splats.size(); ++i) {
      const Eigen::Vector3d center = world * splats.position_at(i, frame);
      report.low = report.low.cwiseMin(center);
      report.high = report.high.cwiseMax(center);
    }
  }
}

ObjectReport report_object(const Scene& scene, const Object& object, const ObjectSource& source) {
  const double open = scene.frame + scene.shutter.open, close = scene.frame + scene.shutter.close;
  const SurfelCloud& cloud = object.cloud;
  ObjectReport report;
  report.name = object.name;
  report.source = describe(source);
  report.points = cloud.size();
  report.keys = cloud.keys.size();
  report.points_move = points_move(cloud, open, close);
  report.object_moves = !object.transform.constant_over(open, close);
  if (!cloud.velocity.empty())
    report.velocity_unit = source.velocity == VelocityUnit::per_frame ? "per_frame" : "per_second";
  report.longest_streak_px = longest_streak_px(scene, object);
  report.has_opacity = cloud.see_through();
  report.two_sided = object.two_sided;
  report.segments = most_segments(scene, object, scene.exposure());
  report.low.setConstant(std::numeric_limits<double>::infinity());
  report.high = -report.low;
  if (object.splats.size() > 0) {
    if (!object.splats.velocity.empty())
      report.velocity_unit = source.velocity == VelocityUnit::per_frame ? "per_frame" : "per_second";
    report_splats(object, open, close, report);
    return report;
  }
  for (const double frame : {open, open + 0.5 * (close - open), close}) {
    if (cloud.size() == 0) break;
    const Eigen::Affine3d world = object.transform.at(frame);
    const SurfelsAt surfels(cloud, frame);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const SurfelInstant surfel = surfels[i];
      const Eigen::Vector3d center = world * surfel.position;
      // An ellipse {c + u a₁ + v a₂} reaches √(a₁ᵢ² + a₂ᵢ²) along coordinate i.
      const Eigen::Vector3d reach = ((world.linear() * surfel.axis_u).array().square() +
                                     (world.linear() * surfel.axis_v).array().square())
                                        .sqrt();
      report.low = report.low.cwiseMin(center - reach);
      report.high = report.high.cwiseMax(center + reach);
    }
  }
  return report;
}

CameraReport report_camera(const Scene& scene) {
  const double open = scene.frame + scene.shutter.open, close = scene.frame + scene.shutter.close;
  const CameraInstant camera = scene.camera.at(open + 0.5 * (close - open));
  const Eigen::Matrix3d axes = camera.camera_from_world.linear();
  constexpr double degrees = 180.0 / std::numbers::pi;
  const Projection projection = projection_of(scene.film, camera);
  const Eigen::Vector2d focal(projection.focal_px * camera.lens.stretch_x, projection.focal_px);
  const Eigen::Vector2d center(projection.center_x, projection.center_y);
  const auto fov = [&](int axis, double size) {
    return (std::atan((size - center[axis]) / focal[axis]) + std::atan(center[axis] / focal[axis])) * degrees;
  };
  const bool parallel = camera.orthographic;
  return {camera.eye,
          axes.row(0),
          axes.row(1),
          axes.row(2),
          parallel ? 0.0 : fov(0, scene.film.width),
          parallel ? 0.0 : fov(1, scene.film.height),
          scene.camera.near,
          parallel ? 2.0 * camera.tan_half_fov_y : 0.0,
          focal,
          center,
          !scene.camera.constant_over(open, close)};
}

std::string objects(std::ptrdiff_t count) {
  return count == 1 ? "1 object" : fmt::format("{} objects", count);
}

std::vector<std::string> effects_of(const Scene& scene, const SceneReport& report) {
  const auto count = [&](auto property) {
    return std::count_if(report.objects.begin(), report.objects.end(), property);
  };
  std::vector<std::string> effects;
  const auto points = count([](const ObjectReport& object) { return object.points_move; });
  const auto whole = count([](const ObjectReport& object) { return object.object_moves; });
  if (scene.shutter.open == scene.shutter.close)
    effects.push_back("no motion blur: the shutter opens and closes at once");
  else if (points + whole == 0 && !report.camera.moves)
    effects.push_back("no motion blur: nothing moves while the shutter is open");
  if (points > 0) effects.push_back("motion blur of points within " + objects(points));
  if (whole > 0) effects.push_back("motion blur from the transforms of " + objects(whole));
  if (report.camera.moves) effects.push_back("motion blur of the camera");
  int segments = 1;
  for (const ObjectReport& object : report.objects)
    if (object.points_move || object.object_moves || report.camera.moves)
      segments = std::max(segments, object.segments);
  if (segments > 1) effects.push_back(fmt::format("curved motion, up to {} linear segments", segments));
  if (const auto n = count([](const ObjectReport& object) { return object.has_opacity; }); n > 0)
    effects.push_back("transparency of " + objects(n));
  if (const auto n = count([](const ObjectReport& object) { return !object.two_sided; }); n > 0)
    effects.push_back("one-sided culling of " + objects(n));
  if (scene.camera.aperture.radius > 0.0)
    effects.push_back(
        scene.camera.aperture.samples > 0
            ? fmt::format("depth of field through {} points of the lens", lens_point_count(scene))
            : fmt::format("depth of field through as many points of the lens as the error takes, "
                          "or {} where none is asked for",
                          lens_point_count(scene)));
  if (scene.camera.orthographic) effects.push_back("parallel rays: the camera is orthographic");
  if (scene.model.filter_radius_px > 0.0)
    effects.push_back(fmt::format("pixel filter of {} px", scene.model.filter_radius_px));
  effects.push_back(scene.model.coverage == Coverage::soft ? "soft silhouettes" : "hard silhouettes");
  return effects;
}

}  // namespace

SceneReport report_scene(const SceneFile& file, const Scene& scene) {
  SceneReport report;
  const double length = scene.shutter.close - scene.shutter.open;
  report.frame = scene.frame;
  report.notes = file.notes();
  report.exposure_seconds = length * scene.fps.denominator / scene.fps.numerator;
  report.shutter_angle_degrees = 360.0 * length;
  report.camera = report_camera(scene);
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    report.objects.push_back(report_object(scene, scene.objects[i], file.sources()[i]));
  std::vector<ObjectPlan> plans = effect_plan(scene);
  for (std::size_t i = 0; i < plans.size(); ++i) report.objects[i].plan = std::move(plans[i]);
  report.effects = effects_of(scene, report);
  return report;
}

}  // namespace swept
