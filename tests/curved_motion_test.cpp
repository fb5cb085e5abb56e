// Paths that curve, discs that turn, points that come and go, rows exposed one after the other: every method
// against the reference, which places points by formulas of its own.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "splat/compare/metrics.h"
#include "splat/kernel/kernel_set.h"
#include "splat/motion/cut.h"
#include "splat/motion/path.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

Image reference_of(const Scene& scene, int samples = 512) {
  auto rendered = render_reference(scene, {samples, ReferenceMotion::smooth});
  EXPECT_TRUE(rendered.ok()) << rendered.error().message();
  return rendered->image;
}

double psnr(const Image& image, const Image& truth) {
  return -20.0 * std::log10(test::difference_of(image, truth).color);
}

/// Engine and A-buffer against the reference, dB.
void expect_near_reference(const Scene& scene, double exact_db, int samples = 512) {
  const Image truth = reference_of(scene, samples);
  SampledOptions options;
  options.samples = samples;
  const auto sampled = render_sampled(scene, options);
  ASSERT_TRUE(sampled.ok()) << sampled.error().message();
  EXPECT_GE(psnr(sampled->image, truth), 100.0) << "the same instants, on the true path";
  options.samples = 0;
  options.max_error_db = 60.0;
  const auto chosen = render_sampled(scene, options);
  ASSERT_TRUE(chosen.ok());
  EXPECT_GE(psnr(chosen->image, truth), 58.5) << "instants chosen for 60 dB";
  const auto exact = render_abuffer(scene, {});
  ASSERT_TRUE(exact.ok()) << exact.error().message();
  EXPECT_GE(psnr(exact->image, truth), exact_db);
  std::printf("sampled to 60 dB %.1f dB, exact %.1f dB, %g segments\n", psnr(chosen->image, truth),
              psnr(exact->image, truth), exact->statistics.counter("segments").value_or(0.0));
}

/// Keys at uneven frames, of a sphere that turns and shakes.
Object keyed_sphere(KeyPath path, std::vector<double> frames) {
  Object object = test::checkered_sphere(0.8, 500);
  const SurfelPose rest = object.cloud.keys.front().pose;
  object.cloud.keys.clear();
  object.cloud.path = path;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Eigen::AngleAxisd turn(0.35 * static_cast<double>(k), Vector3d(0.6, 0.0, 0.8));
    const double shake = k % 2 == 0 ? 0.25 : -0.25;
    SurfelKey key{frames[k], rest};
    for (std::size_t i = 0; i < rest.size(); ++i) {
      key.pose.position[i] = turn * rest.position[i] + Vector3d(0.2 * frames[k], shake, 0.0);
      key.pose.axis_u[i] = (turn * rest.axis_u[i].cast<double>()).cast<float>();
      key.pose.axis_v[i] = (turn * rest.axis_v[i].cast<double>()).cast<float>();
    }
    object.cloud.keys.push_back(std::move(key));
  }
  return object;
}

Scene spline_scene() {
  Scene scene = test::stage();
  scene.objects = {keyed_sphere(KeyPath::spline, {-0.8, 0.1, 0.45, 0.8, 1.7})};
  return scene;
}

TEST(Path, SplineGoesThroughItsKeysWithOneVelocity) {
  const SurfelCloud cloud = keyed_sphere(KeyPath::spline, {-1.0, 0.0, 0.5, 2.0}).cloud;
  for (const SurfelKey& key : cloud.keys) {
    const SurfelInstant at = surfel_at(cloud, 7, key.frame);
    EXPECT_LT((at.position - key.pose.position[7]).norm(), 1e-12);
  }
  constexpr double h = 1e-6;
  for (const std::size_t k : {1u, 2u}) {
    const double f = cloud.keys[k].frame;
    const Vector3d at = surfel_at(cloud, 7, f).position;
    const Vector3d before = (at - surfel_at(cloud, 7, f - h).position) / h;
    const Vector3d after = (surfel_at(cloud, 7, f + h).position - at) / h;
    EXPECT_LT((before - after).norm(), 1e-4 * before.norm());
  }
}

TEST(Path, SplineThroughKeysOfAParabolaIsTheParabola) {
  SurfelCloud cloud;
  cloud.path = KeyPath::spline;
  const auto place = [](double f) { return Vector3d(1.0 + f, 2.0 * f * f - f, -f * f); };
  for (const double frame : {0.0, 0.3, 1.0, 1.2, 2.0})
    cloud.keys.push_back({frame, {{place(frame)}, {Vector3f::UnitX()}, {Vector3f::UnitY()}}});
  for (double frame = 0.0; frame <= 2.0; frame += 0.01)
    EXPECT_LT((surfel_at(cloud, 0, frame).position - place(frame)).norm(), 1e-13) << frame;
}

TEST(Path, ControlsGiveThePathBack) {
  for (const auto& cloud : {keyed_sphere(KeyPath::spline, {0.0, 0.4, 1.0}).cloud,
                            keyed_sphere(KeyPath::bezier, {0.0, 0.1, 0.2, 0.3, 0.9, 1.0}).cloud}) {
    const double first = 0.45, last = 0.95;
    const std::vector<PathWeights> controls = path_controls(cloud, first, last);
    ASSERT_EQ(controls.size(), path_degree(cloud) + 1);
    for (const double share : {0.0, 0.25, 0.6, 1.0}) {
      std::vector<Vector3d> points;
      for (const PathWeights& control : controls) points.push_back(SurfelsAt(cloud, control)[3].position);
      while (points.size() > 1) {
        for (std::size_t k = 0; k + 1 < points.size(); ++k)
          points[k] = (1.0 - share) * points[k] + share * points[k + 1];
        points.pop_back();
      }
      const Vector3d truth = surfel_at(cloud, 3, first + share * (last - first)).position;
      EXPECT_LT((points[0] - truth).norm(), 1e-12);
    }
  }
}

TEST(CurvedMotion, SplineIsTheReferences) { expect_near_reference(spline_scene(), 70.0); }

TEST(CurvedMotion, LinearAndSplineDiffer) {
  Scene scene = spline_scene();
  const Image spline = reference_of(scene, 64);
  scene.objects[0].cloud.path = KeyPath::linear;
  EXPECT_LT(psnr(reference_of(scene, 64), spline), 50.0);
}

TEST(CurvedMotion, BezierOfDegreeFiveIsTheReferences) {
  Scene scene = test::stage();
  scene.objects = {keyed_sphere(KeyPath::bezier, {-0.2, 0.1, 0.2, 0.6, 0.8, 1.2})};
  scene.objects[0].transform.keys.resize(2);
  scene.objects[0].transform.keys[1].frame = 1.0;
  scene.objects[0].transform.keys[1].rotate_radians = 0.8;
  scene.motion.tolerance_px = 0.02;
  expect_near_reference(scene, 70.0);
}

Scene ballistic_scene() {
  Scene scene = test::stage();
  Object object = test::checkered_sphere(0.8, 500);
  test::Random random(3);
  SurfelCloud& cloud = object.cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d out = cloud.keys[0].pose.position[i];
    cloud.velocity.push_back((0.8 * out + Vector3d(0.3, 1.0, 0.0)).cast<float>());
    cloud.acceleration.push_back(Vector3f(0.0f, -2.4f, 0.0f));
    cloud.angular_velocity.push_back(random.vector(-2.5, 2.5).cast<float>());
  }
  scene.objects = {object};
  return scene;
}

TEST(CurvedMotion, AccelerationAndSpinAreTheReferences) {
  Scene scene = ballistic_scene();
  scene.motion.tolerance_px = 0.02;
  expect_near_reference(scene, 70.0);
}

TEST(CurvedMotion, SpinsAreTheReferencesAtTheToleranceThatNobodyAskedFor) {
  expect_near_reference(ballistic_scene(), 70.0);
}

TEST(CurvedMotion, OrderOfPointsChangesNoBit) {
  for (Scene scene : {spline_scene(), ballistic_scene()}) {
    SampledOptions options;
    options.samples = 5;
    const auto sampled = render_sampled(scene, options);
    const auto exact = render_abuffer(scene, {});
    SurfelCloud& cloud = scene.objects[0].cloud;
    for (SurfelKey& key : cloud.keys) {
      std::reverse(key.pose.position.begin(), key.pose.position.end());
      std::reverse(key.pose.axis_u.begin(), key.pose.axis_u.end());
      std::reverse(key.pose.axis_v.begin(), key.pose.axis_v.end());
    }
    for (auto* values : {&cloud.color, &cloud.velocity, &cloud.acceleration, &cloud.angular_velocity})
      std::reverse(values->begin(), values->end());
    EXPECT_EQ(render_sampled(scene, options)->image.rgba, sampled->image.rgba);
    EXPECT_EQ(render_abuffer(scene, {})->image.rgba, exact->image.rgba);
  }
}

TEST(CurvedMotion, RatesOfZeroAreNone) {
  Scene scene = ballistic_scene();
  SurfelCloud& cloud = scene.objects[0].cloud;
  cloud.acceleration.clear();
  cloud.angular_velocity.clear();
  SampledOptions options;
  options.samples = 7;
  const auto sampled = render_sampled(scene, options);
  const auto exact = render_abuffer(scene, {});
  cloud.acceleration.assign(cloud.size(), Vector3f::Zero());
  cloud.angular_velocity.assign(cloud.size(), Vector3f::Zero());
  const auto with_zeros = render_sampled(scene, options);
  EXPECT_EQ(with_zeros->image.rgba, sampled->image.rgba);
  EXPECT_EQ(with_zeros->statistics.counter("packed_bytes"), sampled->statistics.counter("packed_bytes"));
  const auto exact_zeros = render_abuffer(scene, {});
  EXPECT_EQ(exact_zeros->image.rgba, exact->image.rgba);
  EXPECT_EQ(exact_zeros->statistics.counter("kernels"), exact->statistics.counter("kernels"));
  cloud.velocity.assign(cloud.size(), Vector3f::Zero());
  EXPECT_EQ(render_abuffer(scene, {})->statistics.counter("intervals"), 0.0);
}

/// Gribel et al. 2013, Fig. 3: the rim of a wheel about the view axis, in small discs.
Scene wheel(double tolerance_px, double radius = 0.02) {
  Scene scene = test::stage();
  scene.film = {256, 256, 0, 0, 0, 0};
  scene.motion.tolerance_px = tolerance_px;
  scene.objects = {test::wheel(64, radius)};
  return scene;
}

TEST(Cut, WheelKeepsItsRadiusWithinTheTolerance) {
  std::printf("tolerance px, segments a point, farthest from the rim px\n");
  double before = 1e9;
  for (const double tolerance : {1.0, 0.3, 0.1, 0.03, 0.01}) {
    const Scene scene = wheel(tolerance);
    const KernelSet set = build_kernels(scene);
    const double per_unit = set.projection.focal_px / 5.0;
    double farthest = 0.0;
    for (const MovingKernel& kernel : set.kernels)
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const double t = kernel.t_begin + share * (kernel.t_end - kernel.t_begin);
        const Vector3d at = kernel.center + (t - kernel.t_mid()) * kernel.velocity;
        farthest = std::max(farthest, std::abs(at.head<2>().norm() - 1.5) * per_unit);
      }
    std::printf("%12g %17d %27.4f\n", tolerance, set.most_segments, farthest);
    EXPECT_LE(farthest, tolerance);
    EXPECT_LE(farthest, before);
    before = farthest;
  }
}

TEST(Cut, ADiscThatTurnsWithinItsPlaneTakesNoMoreSegments) {
  const KernelSet small = build_kernels(wheel(0.1, 0.002)), large = build_kernels(wheel(0.1, 0.5));
  EXPECT_EQ(small.kernels.size(), large.kernels.size());
  Scene ellipses = wheel(0.1, 0.5);
  for (Vector3f& axis : ellipses.objects[0].cloud.keys[0].pose.axis_u) axis *= 0.5f;
  EXPECT_GT(build_kernels(ellipses).kernels.size(), 2 * large.kernels.size());
}

TEST(Cut, ParallelRaysCutADiscAlikeWhereverItIs) {
  const auto segments_at = [](double x) {
    Scene scene = test::stage();
    scene.camera.orthographic = true;
    scene.camera.look_ats[0].tan_half_fov_y = 4.0;
    scene.motion.tolerance_px = 0.01;
    Object object;
    test::add_disc(object, {x, 0.0, 0.0}, Vector3d(0.0, 0.6, 0.8), 0.4);
    object.cloud.keys[0].pose.axis_v[0] *= 0.3f;
    object.cloud.angular_velocity.push_back(Vector3f(2.0f, 0.5f, 0.0f));
    scene.objects = {object};
    return build_kernels(scene).kernels.size();
  };
  EXPECT_GT(segments_at(0.0), 4u);
  EXPECT_EQ(segments_at(4.0), segments_at(0.0));
}

TEST(Cut, StraightPointsAreOneSegmentBesideCurvedOnes) {
  Scene scene = test::stage();
  scene.film = {512, 512, 0, 0, 0, 0};
  Object object;
  test::Random random(1);
  for (int i = 0; i < 200; ++i) {
    test::add_disc(object, random.vector(-1.0, 1.0), Vector3d::UnitZ(), 0.02);
    object.cloud.velocity.push_back(Vector3f(2.0f, 0.0f, 0.0f));
    object.cloud.acceleration.push_back(i < 2 ? Vector3f(0.0f, 40.0f, 0.0f) : Vector3f::Zero());
  }
  scene.objects = {object};
  const KernelSet set = build_kernels(scene);
  EXPECT_GE(set.most_segments, 16);
  EXPECT_LE(set.kernels.size(), 198u + 2u * static_cast<std::size_t>(set.most_segments));
}

TEST(Cut, HalfPathsOfATurningSceneFitTogether) {
  const Scene scene = spline_scene();
  PathCutter cutter(scene, scene.objects[0], scene.exposure());
  for (std::size_t i = 0; i < 50; ++i) {
    const std::vector<PathSegment>& path = cutter.cut(i, 0.02);
    EXPECT_EQ(path.front().begin, 0.0);
    EXPECT_EQ(path.back().end, 1.0);
    for (std::size_t s = 1; s < path.size(); ++s) {
      EXPECT_EQ(path[s].begin, path[s - 1].end);
      EXPECT_LT((path[s].first - path[s - 1].last).norm(), 1e-12);
    }
  }
}

Scene mayfly_scene() {
  Scene scene = ballistic_scene();
  SurfelCloud& cloud = scene.objects[0].cloud;
  test::Random random(9);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double born = random(-1.0, 1.0);
    cloud.lifetime.push_back({born, born + random(0.0, 1.5)});
  }
  return scene;
}

TEST(Lifetimes, PointsAreThereForTheirPartOfTheExposure) {
  Scene scene = mayfly_scene();
  scene.motion.tolerance_px = 0.02;
  const int samples = 2048;
  const Image truth = reference_of(scene, samples);
  SampledOptions options;
  options.samples = samples;
  const auto sampled = render_sampled(scene, options);
  ASSERT_TRUE(sampled.ok());
  EXPECT_GE(psnr(sampled->image, truth), 100.0);
  const auto exact = render_abuffer(scene, {});
  ASSERT_TRUE(exact.ok());
  EXPECT_GE(psnr(exact->image, truth), 65.0);
  options.samples = 0;
  const auto chosen = render_sampled(scene, options);
  EXPECT_GE(psnr(chosen->image, truth), 57.0);
  std::printf("chosen %.1f dB, exact %.1f dB\n", psnr(chosen->image, truth), psnr(exact->image, truth));
}

TEST(Lifetimes, HalfAnExposureIsHalfTheLight) {
  Scene scene = test::stage();
  Object object;
  test::add_disc(object, Vector3d::Zero(), Vector3d::UnitZ(), 0.8);
  object.cloud.lifetime = {{-3.0, 0.25}};
  scene.objects = {object};
  const auto exact = render_abuffer(scene, {});
  ASSERT_TRUE(exact.ok());
  const std::size_t middle = 4 * (24u * 64u + 32u);
  EXPECT_NEAR(exact->image.rgba[middle], 0.25f, 1e-6f);
  SampledOptions options;
  options.max_error_db = 75.0;
  const auto sampled = render_sampled(scene, options);
  ASSERT_TRUE(sampled.ok());
  // A step is met to half an instant, and the disc is not opaque to the last digit there.
  EXPECT_NEAR(sampled->image.rgba[middle], 0.25,
              0.51 / sampled->statistics.counter("most_instants").value_or(1));
}

Scene rolling_scene() {
  Scene scene = spline_scene();
  scene.film = {48, 36, 0, 0, 0, 0};
  scene.shutter = {0.0, 0.4};
  scene.shutter.row_delay = 0.5 / 36;
  LookAtKey moved = scene.camera.look_ats.front();
  moved.frame = 1.0;
  moved.eye += Vector3d(0.5, 0.1, 0.3);
  scene.camera.look_ats.push_back(moved);
  return scene;
}

TEST(RollingShutter, EveryRowHasItsOwnTime) {
  const Scene scene = rolling_scene();
  const Image truth = reference_of(scene, 256);
  SampledOptions options;
  options.samples = 256;
  const auto sampled = render_sampled(scene, options);
  ASSERT_TRUE(sampled.ok()) << sampled.error().message();
  EXPECT_GE(psnr(sampled->image, truth), 100.0);
  const auto exact = render_abuffer(scene, {});
  ASSERT_TRUE(exact.ok()) << exact.error().message();
  EXPECT_GE(psnr(exact->image, truth), 70.0);
  options.samples = 0;
  const auto chosen = render_sampled(scene, options);
  EXPECT_GE(psnr(chosen->image, truth), 58.5);
  std::printf("chosen %.1f dB, exact %.1f dB\n", psnr(chosen->image, truth), psnr(exact->image, truth));
}

TEST(RollingShutter, ARowIsThatRowOfAPictureTakenThen) {
  Scene scene = rolling_scene();
  SampledOptions options;
  options.samples = 16;
  const auto rolling = render_sampled(scene, options);
  ASSERT_TRUE(rolling.ok());
  const int y = 21;
  Scene then = scene;
  then.shutter.open += y * scene.shutter.row_delay;
  then.shutter.close += y * scene.shutter.row_delay;
  then.shutter.row_delay = 0.0;
  const auto whole = render_sampled(then, options);
  ASSERT_TRUE(whole.ok());
  for (std::size_t i = 4 * 48 * y; i < 4 * 48 * (y + 1); ++i)
    EXPECT_NEAR(rolling->image.rgba[i], whole->image.rgba[i], 2e-6f) << i;
  scene.film.crop_x = 5;
  scene.film.crop_y = 20;
  scene.film.crop_width = 30;
  scene.film.crop_height = 4;
  const auto crop = render_sampled(scene, options);
  ASSERT_TRUE(crop.ok());
  for (std::size_t x = 0; x < 4 * 30; ++x)
    EXPECT_EQ(crop->image.rgba[4 * 30 + x], rolling->image.rgba[4 * (48 * 21 + 5) + x]);
}

TEST(RollingShutter, InstantsAreStillsOfTheirRows) {
  Scene scene = rolling_scene();
  scene.shutter.close = scene.shutter.open;
  const Image truth = reference_of(scene, 2);
  const auto sampled = render_sampled(scene, {});
  ASSERT_TRUE(sampled.ok());
  EXPECT_GE(psnr(sampled->image, truth), 100.0);
  const auto exact = render_abuffer(scene, {});
  ASSERT_TRUE(exact.ok());
  EXPECT_EQ(exact->image.rgba, sampled->image.rgba);
}

TEST(RollingShutter, WhatCannotBeDoneIsRefusedByName) {
  Scene scene = rolling_scene();
  scene.shutter.curve = ShutterShape::gaussian;
  EXPECT_EQ(render_abuffer(scene, {}).error().field, "/shutter/curve");
  scene.shutter.curve = ShutterShape::box;
  scene.model.segments = 3;
  EXPECT_EQ(render_abuffer(scene, {}).error().field, "/image/segments");
  scene.model.segments = 0;
  SampledOptions options;
  options.max_seconds = 1.0;
  EXPECT_EQ(render_sampled(scene, options).error().field, "max_seconds");
  EXPECT_EQ(render_reference(scene, {2, ReferenceMotion::segments}).error().field, "/shutter/row_delay");
}

TEST(Stamps, PathsAreAtTheirPoseAtTheirOwnTime) {
  SurfelCloud cloud = ballistic_scene().objects[0].cloud;
  const SurfelCloud before = cloud;
  std::vector<double> stamps;
  test::Random random(4);
  for (std::size_t i = 0; i < cloud.size(); ++i) stamps.push_back(random(-3.0, 2.0));
  ASSERT_TRUE(shift_to_stamps(cloud, stamps).ok());
  for (std::size_t i = 0; i < cloud.size(); i += 17)
    for (const double later : {-1.0, 0.0, 0.7}) {
      const SurfelInstant now = surfel_at(cloud, i, stamps[i] + later);
      const SurfelInstant then = surfel_at(before, i, later);
      EXPECT_LT((now.position - then.position).norm(), 1e-5);
      EXPECT_LT((now.axis_u - then.axis_u).norm(), 1e-6);
      EXPECT_LT((now.axis_v - then.axis_v).norm(), 1e-6);
    }
  EXPECT_FALSE(shift_to_stamps(cloud, {}).ok());
  stamps[3] = NAN;
  EXPECT_EQ(shift_to_stamps(cloud, stamps).error().field, "stamps[3]");
}

TEST(CurvedMotion, BadCloudsAreNamed) {
  SurfelCloud cloud = ballistic_scene().objects[0].cloud;
  cloud.acceleration[5].x() = NAN;
  EXPECT_EQ(cloud.validate().error().field, "acceleration[5]");
  cloud.acceleration.pop_back();
  EXPECT_EQ(cloud.validate().error().field, "acceleration");
  cloud.acceleration.clear();
  cloud.lifetime.assign(cloud.size(), {1.0, 0.0});
  EXPECT_EQ(cloud.validate().error().field, "lifetime[0]");
  cloud.lifetime.clear();
  cloud.keys.push_back(cloud.keys.front());
  cloud.keys.back().frame = 2.0;
  cloud.velocity.clear();
  EXPECT_EQ(cloud.validate().error().field, "angular_velocity");
}

}  // namespace
}  // namespace swept
