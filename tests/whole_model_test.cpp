// Every effect of motion, time, camera and look, on a scene made to stress it, and the horse's gallop: the
// exact method and the sampled engine against the reference along the true path.
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "splat/io/scene_file.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/point_files.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

struct Effect {
  const char* name;
  std::function<void(Scene&)> apply;
  int instants = 512;   ///< of the reference
  bool changes = true;  ///< whether the picture without it has as many pixels and is another
};

std::ostream& operator<<(std::ostream& out, const Effect& effect) { return out << effect.name; }

SurfelCloud& ball(Scene& scene) { return scene.objects[0].cloud; }

void give_rates(SurfelCloud& cloud, const Vector3d& velocity, double outward) {
  cloud.velocity.clear();
  for (const Vector3d& at : cloud.keys[0].pose.position)
    cloud.velocity.push_back((velocity + outward * at).cast<float>());
}

/// Poses of a ball that turns about an axis, goes aside and shakes, at uneven frames.
void give_keys(SurfelCloud& cloud, KeyPath path) {
  const SurfelPose rest = cloud.keys.front().pose;
  cloud.keys.clear();
  cloud.path = path;
  int k = 0;
  for (const double frame : {-0.8, 0.1, 0.45, 0.8, 1.7}) {
    const Eigen::AngleAxisd by(0.35 * k, Vector3d(0.6, 0.0, 0.8));
    SurfelKey key{frame, rest};
    for (std::size_t i = 0; i < rest.size(); ++i) {
      key.pose.position[i] = by * rest.position[i] + Vector3d(0.4 * frame, k % 2 == 0 ? 0.25 : -0.25, 0.0);
      key.pose.axis_u[i] = (by * rest.axis_u[i].cast<double>()).cast<float>();
      key.pose.axis_v[i] = (by * rest.axis_v[i].cast<double>()).cast<float>();
    }
    cloud.keys.push_back(std::move(key));
    ++k;
  }
}

void spin(SurfelCloud& cloud, double most) {
  test::Random random(3);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.angular_velocity.push_back(random.vector(-most, most).cast<float>());
}

/// Two looks, at the exposure's ends.
void give_looks(SurfelCloud& cloud, bool colors, bool opacities) {
  test::Random random(11);
  const auto first = cloud.color;
  for (const double frame : {0.0, 1.0}) {
    LookKey& key = cloud.looks.emplace_back();
    key.frame = frame;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      key.color.push_back(colors ? random.vector(0.0, 1.0).cast<float>() : first[i]);
      if (opacities) key.opacity.push_back(static_cast<float>(random(0.0, 1.0)));
    }
  }
}

LookAtKey& second_camera(Scene& scene) {
  scene.camera.look_ats.push_back(scene.camera.look_ats.front());
  scene.camera.look_ats[1].frame = 1.0;
  return scene.camera.look_ats[1];
}

void give_shutter(Scene& scene, ShutterShape shape) {
  scene.shutter.curve = shape;
  scene.shutter.opening = 0.3;
  scene.shutter.closing = 0.1;
  scene.shutter.delta = 4.0;
  scene.shutter.rates = {0.0, 3.0, 0.0, 0.0, 1.0};
}

/// A red side over a blue one; the sheet turns its back, through edge-on.
Object sheet() {
  Object object;
  for (const double side : {1.0, -1.0})
    for (int i = 0; i < 144; ++i)
      test::add_disc(object, {-0.8 + 1.6 * (i % 12) / 11.0, -0.8 + 1.6 * (i / 12) / 11.0, 0.01 * side},
                     {0, 0, side}, 0.12,
                     side > 0.0 ? Vector3f(1.0f, 0.0f, 0.0f) : Vector3f(0.0f, 0.0f, 1.0f));
  object.cloud.oriented.assign(object.cloud.size(), 1);
  return object;
}

const std::vector<Effect>& effects() {
  static const std::vector<Effect> all = {
      {"Straight", [](Scene&) {}, 512, false},
      {"BezierPath", [](Scene& s) { give_keys(ball(s), KeyPath::bezier); }},
      {"SplinePath", [](Scene& s) { give_keys(ball(s), KeyPath::spline); }},
      {"PiecewiseLinearPath", [](Scene& s) { give_keys(ball(s), KeyPath::linear); }},
      {"Acceleration",
       [](Scene& s) {
         give_rates(ball(s), {0.3, 1.0, 0.0}, 0.8);
         ball(s).acceleration.assign(ball(s).size(), Vector3f(0.0f, -2.4f, 0.0f));
       }},
      {"AngularVelocity", [](Scene& s) { spin(ball(s), 2.5); }},
      {"AllRatesAtOnce",
       [](Scene& s) {
         give_rates(ball(s), {0.3, 1.0, 0.0}, 0.8);
         ball(s).acceleration.assign(ball(s).size(), Vector3f(0.0f, -2.4f, 0.0f));
         spin(ball(s), 2.5);
       }},
      {"SpinOfTheObject",
       [](Scene& s) {
         test::move(s.objects[0], {-0.5, 0.1, 0}, {0.6, 0.0, 0.3}, 1.5);
       }},
      {"ObjectThatGrows",
       [](Scene& s) {
         s.objects[0].transform.keys[1].scale = {1.5, 1.3, 1.2};
       }},
      {"DiscsThatGrow",
       [](Scene& s) {
         ball(s).keys.push_back(ball(s).keys[0]);
         ball(s).keys[1].frame = 1.0;
         for (std::size_t i = 0; i < ball(s).size(); i += 2) {
           ball(s).keys[1].pose.axis_u[i] *= 3.0f;
           ball(s).keys[1].pose.axis_v[i] *= 3.0f;
         }
       }},
      {"PointsThatComeAndGo",
       [](Scene& s) {
         test::Random random(9);
         for (std::size_t i = 0; i < ball(s).size(); ++i) {
           const double born = random(-1.0, 1.0);
           ball(s).lifetime.push_back({born, born + random(0.0, 1.5)});
         }
       },
       2048},
      {"TimeStamps",
       [](Scene& s) {
         give_rates(ball(s), {0.3, 0.6, 0.0}, 0.8);
         spin(ball(s), 1.0);
         std::vector<double> stamps;
         test::Random random(4);
         for (std::size_t i = 0; i < ball(s).size(); ++i) stamps.push_back(random(-0.5, 0.5));
         ASSERT_TRUE(shift_to_stamps(ball(s), stamps).ok());
       }},
      {"RollingShutter",
       [](Scene& s) {
         s.shutter.close = 0.5;
         s.shutter.row_delay = 0.5 / 48;
       }},
      {"Trapezoid", [](Scene& s) { give_shutter(s, ShutterShape::trapezoid); }},
      {"Gaussian", [](Scene& s) { give_shutter(s, ShutterShape::gaussian); }},
      {"TableOfTheShutter", [](Scene& s) { give_shutter(s, ShutterShape::table); }},
      {"SplineUnderAGaussian",
       [](Scene& s) {
         give_keys(ball(s), KeyPath::spline);
         give_shutter(s, ShutterShape::gaussian);
       }},
      {"PrincipalPoint",
       [](Scene& s) {
         s.camera.look_ats[0].lens.shift = {0.2, -0.1};
         second_camera(s).lens.shift = {-0.1, 0.15};
       }},
      {"TwoFocalLengths",
       [](Scene& s) {
         s.camera.look_ats[0].lens.stretch_x = 1.3;
         second_camera(s).lens.stretch_x = 0.8;
       }},
      {"Roll", [](Scene& s) { second_camera(s).roll_radians = 0.6; }},
      {"Zoom", [](Scene& s) { second_camera(s).tan_half_fov_y *= 0.7; }},
      {"Overscan",
       [](Scene& s) {
         s.camera.look_ats[0].lens.shift = {-0.45, -0.4};
         s.film.overscan_left = 5, s.film.overscan_top = 3;
         s.film.overscan_right = 9, s.film.overscan_bottom = 1;
       },
       512, false},
      {"Orthographic",
       [](Scene& s) {
         s.camera.orthographic = true;
         s.camera.look_ats[0].tan_half_fov_y = 2.0;
         second_camera(s).tan_half_fov_y = 1.6;
       }},
      {"Lens",
       [](Scene& s) {
         s.camera.aperture = {0.3, 0, 0.0, 16};
         s.camera.look_ats[0].lens.focus = 4.0;
         second_camera(s).lens.focus = 3.5;
       },
       64},
      {"LensOfBlades",
       [](Scene& s) {
         s.camera.aperture = {0.2, 5, 0.3, 16};
         s.camera.look_ats[0].lens.focus = 3.5;
         second_camera(s).lens.focus = 3.5;
       },
       64},
      {"Colors", [](Scene& s) { give_looks(ball(s), true, false); }},
      {"Opacities", [](Scene& s) { give_looks(ball(s), false, true); }},
      {"ColorsOpacitiesAndRadii",
       [](Scene& s) {
         give_looks(ball(s), true, true);
         ball(s).keys.push_back(ball(s).keys[0]);
         ball(s).keys[1].frame = 1.0;
         for (Vector3f& axis : ball(s).keys[1].pose.axis_u) axis *= 1.6f;
         for (Vector3f& axis : ball(s).keys[1].pose.axis_v) axis *= 1.6f;
       }},
      {"TwoSides", [](Scene& s) {
         s.objects[0] = sheet();
         test::move(s.objects[0], {-0.5, 0.1, 0.2}, {0.6, 0.0, 0.3}, 2.0);
       }}};
  return all;
}

/// A ball that goes aside by 11 px before one that stands still.
Scene plain() {
  Scene scene = test::stage();
  scene.objects = {test::checkered_sphere(0.8, 300), test::checkered_sphere(0.9, 200)};
  test::move(scene.objects[0], {-0.5, 0.1, 0.0}, {0.6, 0.0, 0.3});
  test::move(scene.objects[1], {0.2, 0.3, -1.5}, {0.2, 0.3, -1.5});
  return scene;
}

using test::decibels;

class WholeModel : public testing::TestWithParam<Effect> {};

TEST_P(WholeModel, AreTheReferences) {
  const Effect& effect = GetParam();
  Scene scene = plain();
  effect.apply(scene);
  const auto reference = render_reference(scene, {effect.instants, ReferenceMotion::smooth});
  ASSERT_TRUE(reference.ok()) << reference.error().message();
  const Image& truth = reference->image;
  SampledOptions options;
  options.max_error_db = 72.0;
  if (scene.camera.aperture.radius > 0.0) options.samples = effect.instants * scene.camera.aperture.samples;
  const double sampled = decibels(test::value_of(render_sampled(scene, options)).image, truth);
  const double exact = decibels(test::exact(scene).image, truth);
  std::printf("%s: sampled %.1f dB, exact %.1f dB, of itself the reference says %.1f\n", effect.name, sampled,
              exact, reference->statistics.counter("reference_error_psnr_db").value_or(0.0));
  EXPECT_GE(sampled, 70.0);
  EXPECT_GE(exact, 70.0);
  if (!effect.changes) return;
  EXPECT_LE(decibels(test::exact(plain()).image, truth), 45.0) << "it changes nothing";
}

/// What stands still costs no events: those of one moving object are in the pixels that it sweeps by itself.
TEST(WholeModelCosts, OnlyPixelsThatAreSweptAre) {
  const auto fragments = [](const Rendered& of) { return of.statistics.counter("fragments").value_or(0.0); };
  for (const double radius : {0.1, 0.2, 0.4}) {
    Scene scene = test::stage();
    scene.objects = {test::checkered_sphere(radius, 60)};
    test::move(scene.objects[0], {-0.3, 0.1, 2.0}, {0.2, 0.0, 2.0});
    const auto alone = render_abuffer(scene);
    scene.objects.push_back(test::checkered_sphere(1.6, 800));
    const auto together = render_abuffer(scene);
    ASSERT_TRUE(alone.ok() && together.ok());
    const double swept = alone->statistics.counter("pixels_swept").value_or(0.0);
    EXPECT_GT(swept, 0.0);
    EXPECT_LT(swept, 64.0 * 48.0 / 4.0);
    EXPECT_EQ(together->statistics.counter("pixels_swept"), swept) << radius;
    EXPECT_GT(together->statistics.counter("pixels_still").value_or(0.0), 600.0);
    // Of a whole pixel's normalisation all fragments are needed.
    AbufferOptions options;
    options.normalisation = Normalisation::pixel;
    const auto all = render_abuffer(scene, options);
    ASSERT_TRUE(all.ok());
    const double of_mover = fragments(*alone);
    EXPECT_LT(fragments(*together) - of_mover, 0.6 * (fragments(*all) - of_mover)) << radius;
    options = {};
    options.tile_px = 5;
    const auto tiled = render_abuffer(scene, options);
    ASSERT_TRUE(tiled.ok());
    EXPECT_EQ(tiled->image.rgba, together->image.rgba);
    EXPECT_EQ(tiled->image.depth, together->image.depth);
  }
}

/// Keyed poses through a spline, unasked: legs go by 17 px.
TEST(WholeModelOfFiles, TheHorsesGallopAreTheReferences) {
  SWEPT_DATA_OR_SKIP(data);
  const test::TemporaryFolder folder;
  test::put(folder / "horse.json",
            R"({"swept": 1, "frame": 5, "film": {"width": 320, "height": 240},
                "camera": {"fov": {"axis": "vertical", "degrees": 40},
                           "keys": [{"eye": [2.4, 1.0, 0.6], "target": [0, 0.75, -0.25]}]},
                "shutter": {"open": 0.0, "close": 1.0}, "motion": {"path": "spline"},
                "objects": [{"source": {"sequence": ")" +
                data + R"(horse/%04d.obj", "first": 1, "last": 12, "cycle": true}}]})");
  auto file = read_scene_file(folder / "horse.json");
  ASSERT_TRUE(file.ok()) << file.error().message();
  const auto no_generator = [](const std::string&, std::size_t, const std::map<std::string, double>&) {
    return Result<SurfelCloud>(Error{"", "generator", "none"});
  };
  const auto scene = file->scene_at(5.0, no_generator);
  ASSERT_TRUE(scene.ok()) << scene.error().message();
  ASSERT_EQ((*scene)->objects[0].cloud.path, KeyPath::spline);
  const Image truth = test::reference(**scene, 192);
  SampledOptions options;
  options.max_error_db = 75.0;  // of the reference 192 instants are not all of the truth
  const double sampled = decibels(test::value_of(render_sampled(**scene, options)).image, truth);
  const double exact = decibels(test::exact(**scene).image, truth);
  std::printf("the horse's gallop: sampled %.1f dB, exact %.1f dB\n", sampled, exact);
  EXPECT_GE(sampled, 70.0);
  EXPECT_GE(exact, 70.0);
}

INSTANTIATE_TEST_SUITE_P(, WholeModel, testing::ValuesIn(effects()),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace swept
