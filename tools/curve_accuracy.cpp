// How far the exact method's picture is from the true paths, at each tolerance that paths are cut by, on
// scenes that each stress one effect; and for a wheel and spinning discs also at each number of segments that
// all points have alike.
//
// Usage: swept_curve_accuracy [--scenes NAME,…] [--tolerances T,…] [--reference N] [--alike N,…] [--chords]
// Prints Markdown; with --chords what comes out unasked with chords and axes that stand still for segments,
// too. The truth is N instants of the sampled engine, which places points on the true path.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/sampled.h"
#include "splat/compare/metrics.h"
#include "splat/motion/cut.h"
#include "tools/cpu_seconds.h"
#include "tools/random_numbers.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

Scene stage() {
  Scene scene;
  scene.film = {256, 192, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back();  // from z = 5 along −z
  return scene;
}

void add(Object& object, const Vector3d& at, const Vector3d& axis_u, const Vector3d& axis_v, bool odd) {
  if (object.cloud.keys.empty()) object.cloud.keys.resize(1);
  SurfelPose& pose = object.cloud.keys.front().pose;
  pose.position.push_back(at);
  pose.axis_u.push_back(axis_u.cast<float>());
  pose.axis_v.push_back(axis_v.cast<float>());
  object.cloud.color.push_back(odd ? Vector3f(0.9f, 0.2f, 0.1f) : Vector3f(0.1f, 0.3f, 0.9f));
}

/// Of round discs, or ones longer one way by `longer`.
Object sphere(double radius, int points, double longer = 1.0) {
  Object object;
  for (int i = 0; i < points; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / points, angle = i * 2.399963229728653;
    const Vector3d n(std::sqrt(1.0 - z * z) * std::cos(angle), std::sqrt(1.0 - z * z) * std::sin(angle), z);
    const double r = radius * std::sqrt(4.0 * std::numbers::pi / points);
    const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
    const bool odd = (static_cast<int>((n.x() + 1.0) * 4.0) + static_cast<int>((n.y() + 1.0) * 4.0)) % 2 != 0;
    add(object, radius * n, longer * r * u, r * v, odd);
  }
  return object;
}

void turn(Object& object, const Vector3d& axis, double radians) {
  object.transform.keys.resize(2);
  object.transform.keys[1].frame = 1.0;
  for (TransformKey& key : object.transform.keys) key.rotate_axis = axis.normalized();
  object.transform.keys[1].rotate_radians = radians;
}

/// A disc of spokes that turns by 90° about the view axis (Gribel et al. 2013, Fig. 3).
Scene wheel(double longer) {
  Scene scene = stage();
  Object object;
  constexpr int points = 3000;
  for (int i = 0; i < points; ++i) {
    const double r = 1.6 * std::sqrt((i + 0.5) / points), angle = i * 2.399963229728653;
    const double size = 1.6 * std::sqrt(std::numbers::pi / points);
    const Vector3d out(std::cos(angle), std::sin(angle), 0.0), along(-out.y(), out.x(), 0.0);
    const bool odd = static_cast<int>(std::floor(angle * 4.0 / std::numbers::pi)) % 2 != 0;
    add(object, r * out, longer * size * out, size * along, odd);
  }
  turn(object, Vector3d::UnitZ(), 0.5 * std::numbers::pi);
  scene.objects = {object};
  return scene;
}

Scene spinning(double longer, bool flying) {
  Scene scene = stage();
  Object object = sphere(1.2, 1500, longer);
  SurfelCloud& cloud = object.cloud;
  Random random(7);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d out = cloud.keys[0].pose.position[i];
    cloud.velocity.push_back(flying ? Vector3f((0.8 * out + Vector3d(0.3, 1.0, 0.0)).cast<float>())
                                    : Vector3f::Zero());
    cloud.acceleration.push_back(flying ? Vector3f(0.0f, -2.4f, 0.0f) : Vector3f::Zero());
    cloud.angular_velocity.push_back(random.vector(-2.5, 2.5).cast<float>());
  }
  scene.objects = {object};
  return scene;
}

Scene turning_ball() {
  Scene scene = stage();
  Object object = sphere(1.5, 2000);
  turn(object, {0.3, 1.0, 0.5}, 1.2);
  scene.objects = {object};
  return scene;
}

/// Discs of many sizes that come towards the eye and by it.
Scene fly_through() {
  Scene scene = stage();
  Object object;
  Random random(11);
  for (int i = 0; i < 400; ++i) {
    const Vector3d at(random(-1.5, 1.5), random(-1.2, 1.2), random(-3.0, 3.0));
    const Vector3d n = random.vector(-1.0, 1.0).normalized(), u = n.unitOrthogonal(), v = n.cross(u);
    const double r = 0.01 * std::pow(10.0, random(0.0, 1.0));
    add(object, at, r * u, r * v, i % 2 != 0);
    object.cloud.velocity.emplace_back(0.1f, 0.05f, static_cast<float>(random(1.0, 4.0)));
  }
  scene.objects = {object};
  return scene;
}

Scene spline() {
  Scene scene = stage();
  Object object = sphere(1.2, 1500);
  const SurfelPose rest = object.cloud.keys.front().pose;
  object.cloud.keys.clear();
  object.cloud.path = KeyPath::spline;
  int k = 0;
  for (const double frame : {-0.8, 0.1, 0.45, 0.8, 1.7}) {
    const Eigen::AngleAxisd by(0.35 * k, Vector3d(0.6, 0.0, 0.8));
    SurfelKey key{frame, rest};
    for (std::size_t i = 0; i < rest.size(); ++i) {
      key.pose.position[i] = by * rest.position[i] + Vector3d(0.2 * frame, k % 2 == 0 ? 0.25 : -0.25, 0.0);
      key.pose.axis_u[i] = (by * rest.axis_u[i].cast<double>()).cast<float>();
      key.pose.axis_v[i] = (by * rest.axis_v[i].cast<double>()).cast<float>();
    }
    object.cloud.keys.push_back(std::move(key));
    ++k;
  }
  scene.objects = {object};
  return scene;
}

/// Radii, colours, and opacities if so asked, all change.
Scene looks(bool transparent) {
  Scene scene = stage();
  Object ball = sphere(1.1, 1500);
  SurfelCloud& cloud = ball.cloud;
  Random random(7);
  for (const double frame : {-0.4, 0.2, 0.3, 1.4}) {
    LookKey& key = cloud.looks.emplace_back();
    key.frame = frame;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      key.color.push_back(random.vector(0.0, 1.0).cast<float>());
      if (transparent) key.opacity.push_back(static_cast<float>(random(0.0, 1.0)));
    }
  }
  cloud.keys.push_back(cloud.keys[0]);
  cloud.keys[1].frame = 1.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    SurfelPose& pose = cloud.keys[1].pose;
    pose.position[i] = 1.2 * pose.position[i];
    pose.axis_u[i] *= 1.3f;
    pose.axis_v[i] *= 1.3f;
  }
  turn(ball, Vector3d::UnitY(), 0.5);
  ball.transform.keys[0].translate = {-0.5, -0.3, 0.0};
  ball.transform.keys[1].translate = {0.4, 0.4, 0.3};
  scene.objects = {ball, sphere(1.3, 1000)};
  scene.objects[1].transform.keys.resize(1);
  scene.objects[1].transform.keys[0].translate = {0.2, 0.3, -1.5};
  return scene;
}

const std::map<std::string, Scene (*)()>& scenes() {
  static const std::map<std::string, Scene (*)()> all{
      {"wheel", [] { return wheel(1.0); }},
      {"wheel-of-ellipses", [] { return wheel(3.0); }},
      {"spin", [] { return spinning(1.0, false); }},
      {"spin-and-fly", [] { return spinning(1.0, true); }},
      {"spin-of-ellipses", [] { return spinning(3.0, false); }},
      {"ball-that-turns", turning_ball},
      {"fly-through", fly_through},
      {"spline", spline},
      {"looks", [] { return looks(false); }},
      {"looks-and-opacity", [] { return looks(true); }}};
  return all;
}

int run(int argc, char** argv) {
  CLI::App app("How far curved motion is from the true paths");
  std::vector<std::string> names;
  for (const auto& [name, make] : scenes()) names.push_back(name);
  std::vector<double> tolerances{1.0, 0.3, 0.1, 0.03};
  std::vector<int> alike;
  int reference = 1024;
  bool with_chords = false;
  app.add_option("--scenes", names)->delimiter(',');
  app.add_option("--tolerances", tolerances, "px")->delimiter(',')->check(CLI::Range(1e-6, 100.0));
  app.add_option("--alike", alike, "Numbers of segments that all points have alike")->delimiter(',');
  app.add_flag("--chords", with_chords);
  app.add_option("--reference", reference)->check(CLI::Range(1, 1 << 20));
  CLI11_PARSE(app, argc, argv);
  fmt::print("| scene | cut | segments a point | PSNR, dB | CPU s |\n|---|---|---|---|---|\n");
  for (const std::string& name : names) {
    const auto make = scenes().find(name);
    if (make == scenes().end()) return fmt::print(stderr, "There is no scene {}\n", name), 2;
    Scene scene = make->second();
    SampledOptions many;
    many.samples = reference;
    const Result<Rendered> truth = render_sampled(scene, many);
    if (!truth) return fmt::print(stderr, "{}\n", truth.error().message()), 1;
    const auto measure = [&](const std::string& cut, bool chords = false) {
      const double start = cpu_seconds();
      const Result<Rendered> exact = render_abuffer(scene, {.parabolas = !chords});
      const double seconds = cpu_seconds() - start;
      if (!exact) return fmt::print(stderr, "{}\n", exact.error().message()), false;
      const auto metrics = compare_images(exact->image, truth->image);
      fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.2f} |\n", name, cut,
                 exact->statistics.counter("kernels").value_or(0.0) /
                     exact->statistics.counter("surfels").value_or(1.0),
                 metrics ? metrics->psnr_db : 0.0, seconds);
      std::fflush(stdout);
      return true;
    };
    for (const double tolerance : tolerances) {
      scene.motion.tolerance_px = tolerance;
      if (!measure(fmt::format("{} px", tolerance))) return 1;
    }
    scene.motion.tolerance_px = 0.0;
    if (!measure("default") || (with_chords && !measure("default, chords", true))) return 1;
    for (const int segments : alike) {
      scene.model.segments = segments;
      if (!measure(fmt::format("{} alike", segments))) return 1;
    }
  }
  return 0;
}

}  // namespace
}  // namespace swept

int main(int argc, char** argv) { return swept::run(argc, argv); }
