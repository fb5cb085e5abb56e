// The shutter's curve: its share and time are each other's inverse, an edge that sweeps by shows the share,
// and every method that renders agrees.
#include "splat/shutter_curve.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "datasets/generators.h"
#include "splat/compare/metrics.h"
#include "splat/scene.h"

namespace swept {
namespace {

Shutter shutter(ShutterShape curve) {
  Shutter shutter;
  shutter.open = 0.0;
  shutter.close = 1.0;
  shutter.curve = curve;
  shutter.opening = 0.3;
  shutter.closing = 0.1;
  shutter.delta = 4.0;
  shutter.rates = {0.0, 3.0, 0.0, 0.0, 1.0};
  return shutter;
}

constexpr ShutterShape shapes[] = {ShutterShape::trapezoid, ShutterShape::gaussian, ShutterShape::table};

/// The rate by its definition, not normalised.
double rate(const Shutter& s, double time) {
  if (s.curve == ShutterShape::gaussian) return std::exp(-s.delta * std::pow(2.0 * time - 1.0, 2.0));
  if (s.curve == ShutterShape::trapezoid) return std::min({1.0, time / s.opening, (1.0 - time) / s.closing});
  const double at = time * static_cast<double>(s.rates.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), s.rates.size() - 2);
  const double part = at - static_cast<double>(i);
  return s.rates[i] + part * (s.rates[i + 1] - s.rates[i]);
}

/// By the midpoint rule, in many steps.
double share_by_sum(const Shutter& s, double time) {
  constexpr int steps = 100'000;
  double before = 0.0, all = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double at = (i + 0.5) / steps;
    all += rate(s, at);
    if (at < time) before += rate(s, at);
  }
  return before / all;
}

TEST(Shutter, ShareIsTheIntegralOfTheRate) {
  for (const ShutterShape shape : shapes) {
    const Shutter s = shutter(shape);
    const ShutterCurve curve(s);
    for (const double time : {0.0, 0.02, 0.25, 0.3, 0.5, 0.77, 0.95, 1.0})
      EXPECT_NEAR(curve.share(time), share_by_sum(s, time), 3e-5) << static_cast<int>(shape) << ' ' << time;
  }
}

TEST(Shutter, TimeIsTheInverseOfShare) {
  for (const ShutterShape shape : shapes) {
    const ShutterCurve curve(shutter(shape));
    double last = -1.0;
    for (int i = 0; i <= 1000; ++i) {
      const double share = i / 1000.0, time = curve.time(share);
      EXPECT_NEAR(curve.share(time), share, 1e-14);
      EXPECT_GE(time, last);
      last = time;
    }
    EXPECT_EQ(curve.share(0.0), 0.0);
    EXPECT_EQ(curve.share(1.0), 1.0);
  }
  // Sharp ones are nearly flat at the ends.
  Shutter sharp = shutter(ShutterShape::gaussian);
  sharp.delta = 50.0;
  const ShutterCurve curve(sharp);
  for (const double share : {1e-12, 1e-6, 0.5, 1.0 - 1e-6})
    EXPECT_NEAR(curve.share(curve.time(share)), share, 1e-14);
}

TEST(Shutter, RampsOfNoLengthAreABox) {
  Shutter box = shutter(ShutterShape::trapezoid);
  box.opening = box.closing = 0.0;
  const ShutterCurve curve(box);
  for (const double time : {0.0, 0.1, 0.5, 1.0}) {
    EXPECT_DOUBLE_EQ(curve.share(time), time);
    EXPECT_DOUBLE_EQ(curve.time(time), time);
  }
}

TEST(Shutter, PartsOfAnExposureAreShared) {
  Scene scene;
  scene.shutter = shutter(ShutterShape::trapezoid);
  const Exposure whole = scene.exposure(), part = whole.part(0.25, 0.75);
  EXPECT_NEAR(part.at(0.0), whole.at(0.25), 1e-14);
  EXPECT_NEAR(part.at(0.5), whole.at(0.5), 1e-14);
  EXPECT_NEAR(part.at(1.0), whole.at(0.75), 1e-14);
  EXPECT_NEAR(part.share_at(whole.at(0.5)), 0.5, 1e-14);
}

/// One row of pixels that the straight edge of a wide opaque disc sweeps over from the left to the right,
/// once from end to end.
Scene sweeping_edge(const Shutter& shutter) {
  constexpr double radius = 5e5;
  Scene scene;
  scene.film = {100, 1, 0, 0, 0, 0};
  scene.shutter = shutter;
  scene.model.coverage = Coverage::hard;
  scene.model.filter_radius_px = 0.0;
  LookAtKey key;
  key.eye = {0.0, 0.0, 1.0};
  key.tan_half_fov_y = 0.005;  // a pixel is 0.01 units at the disc
  scene.camera.look_ats.push_back(key);
  Object& object = scene.objects.emplace_back();
  object.cloud.keys.resize(1);
  SurfelPose& pose = object.cloud.keys[0].pose;
  pose.position = {Eigen::Vector3d::Zero()};
  pose.axis_u = {Eigen::Vector3f(static_cast<float>(radius), 0.0f, 0.0f)};
  pose.axis_v = {Eigen::Vector3f(0.0f, static_cast<float>(radius), 0.0f)};
  object.transform.keys.resize(2);
  object.transform.keys[0].translate = {-radius - 0.5, 0.0, 0.0};
  object.transform.keys[1].frame = 1.0;
  object.transform.keys[1].translate = {-radius + 0.5, 0.0, 0.0};
  return scene;
}

TEST(Shutter, AnEdgeShowsTheShutter) {
  for (const ShutterShape shape :
       {ShutterShape::box, ShutterShape::trapezoid, ShutterShape::gaussian, ShutterShape::table}) {
    Scene scene = sweeping_edge(shutter(shape));
    scene.model.segments = shape == ShutterShape::box ? 0 : 2048;
    const auto rendered = render_abuffer(scene);
    ASSERT_TRUE(rendered.ok()) << rendered.error().message();
    for (int x = 0; x < 100; ++x) {
      // The edge is at pixel 100 τ.
      const double time = (x + 0.5) / 100.0;
      const double share = shape == ShutterShape::box ? time : ShutterCurve(scene.shutter).share(time);
      EXPECT_NEAR(rendered->image.rgba[4 * static_cast<std::size_t>(x) + 3], 1.0 - share, 1e-5)
          << static_cast<int>(shape) << ' ' << x;
    }
  }
}

TEST(Shutter, AllMethodsAgree) {
  for (const ShutterShape shape : shapes) {
    SCOPED_TRACE(static_cast<int>(shape));
    Scene scene;
    scene.film = {96, 64, 0, 0, 0, 0};
    scene.camera.look_ats.emplace_back();
    scene.shutter = shutter(shape);
    Object& object = scene.objects.emplace_back();
    auto cloud = generate("sphere", 600, {});
    ASSERT_TRUE(cloud.ok());
    object.cloud = std::move(*cloud);
    object.transform.keys.resize(2);
    object.transform.keys[0].translate = {-0.6, 0.0, 0.0};
    object.transform.keys[1].frame = 1.0;
    object.transform.keys[1].translate = {0.6, 0.2, 0.0};
    const auto truth = render_reference(scene, {1024, ReferenceMotion::smooth});
    const auto exact = render_abuffer(scene);
    SampledOptions options;
    options.samples = 1024;
    const auto sampled = render_sampled(scene, options);
    options = {};
    options.max_error_db = 55.0;
    const auto to_error = render_sampled(scene, options);
    ASSERT_TRUE(truth.ok() && exact.ok() && sampled.ok() && to_error.ok());
    const auto psnr = [&](const Rendered& rendered) {
      return compare_images(rendered.image, truth->image)->psnr_db;
    };
    EXPECT_GT(psnr(*sampled), 110.0);
    EXPECT_GT(psnr(*exact), 70.0);
    EXPECT_GT(psnr(*to_error), 52.0);
    // And it is another picture than the box's.
    Scene box = scene;
    box.shutter.curve = ShutterShape::box;
    EXPECT_LT(psnr(*render_abuffer(box)), 45.0);
  }
}

TEST(Shutter, CurvesThatCannotBeAreErrors) {
  Scene scene;
  scene.camera.look_ats.emplace_back();
  scene.shutter = shutter(ShutterShape::trapezoid);
  scene.shutter.opening = 0.95;
  EXPECT_EQ(scene.validate().error().field, "/shutter/closing");
  for (const std::vector<double>& rates : {std::vector<double>{}, {1.0}, {0.0, 0.0, 0.0}}) {
    scene.shutter = shutter(ShutterShape::table);
    scene.shutter.rates = rates;
    ASSERT_FALSE(scene.validate().ok());
    EXPECT_EQ(scene.validate().error().field, "/shutter/rates");
  }
}

}  // namespace
}  // namespace swept
