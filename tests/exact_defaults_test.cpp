// How good the exact method's picture is of motion for which nobody asked for a tolerance or segments:
// against instants of the engine, which places points on their true paths.
#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/sampled.h"
#include "splat/motion/cut.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

/// Of the exact picture, dB. `kernels`: a point.
double psnr_of(const Scene& scene, const char* name) {
  SampledOptions many;
  many.samples = 1024;
  const auto truth = render_sampled(scene, many);
  const auto exact = render_abuffer(scene, {});
  EXPECT_TRUE(truth.ok() && exact.ok()) << name;
  const double db = -20.0 * std::log10(test::difference_of(exact->image, truth->image).color);
  std::printf("%s: %.1f dB, %.1f segments a point\n", name, db,
              exact->statistics.counter("kernels").value_or(0.0) /
                  exact->statistics.counter("surfels").value_or(1.0));
  return db;
}

double segments_of(const Scene& scene) {
  const auto exact = render_abuffer(scene, {});
  EXPECT_TRUE(exact.ok());
  return exact->statistics.counter("segments").value_or(0.0);
}

Scene ball() {
  Scene scene = test::stage();
  scene.film = {128, 96, 0, 0, 0, 0};
  scene.objects = {test::checkered_sphere(1.2, 800)};
  return scene;
}

TEST(ExactDefaults, AnObjectThatTurns) {
  Scene scene = ball();
  test::move(scene.objects[0], {0, 0, 0}, {0, 0, 0}, 1.2);
  EXPECT_GE(psnr_of(scene, "a ball that turns"), 70.0);
  test::move(scene.objects[0], {-0.3, 0.1, 0.0}, {0.4, 0.1, 0.3}, -0.9);
  EXPECT_GE(psnr_of(scene, "a ball that turns and moves"), 70.0);
}

TEST(ExactDefaults, AnObjectThatGrows) {
  Scene scene = ball();
  test::move(scene.objects[0], {0, 0, 0}, {0.3, 0, 0});
  scene.objects[0].transform.keys[1].scale = {1.3, 1.3, 1.3};
  EXPECT_GE(psnr_of(scene, "a ball that grows"), 70.0);
}

TEST(ExactDefaults, ACameraThatPansAndRolls) {
  Scene scene = ball();
  scene.camera.look_ats.push_back(scene.camera.look_ats[0]);
  scene.camera.look_ats[1].frame = 1.0;
  scene.camera.look_ats[1].target = {0.8, 0.2, 0.0};
  EXPECT_GE(psnr_of(scene, "a camera that pans"), 70.0);
  scene.camera.look_ats[1].roll_radians = 0.5;
  EXPECT_GE(psnr_of(scene, "a camera that pans and rolls"), 70.0);
}

/// A corner of the path at a time of which no halving comes near. Without a filter, which depends on
/// where a disc is seen from.
TEST(ExactDefaults, AnObjectThatTurnsBack) {
  Scene scene = ball();
  scene.model.filter_radius_px = 0.0;
  TransformKey open, corner, close;
  open.translate = {-0.4, 0.0, 0.0};
  corner.frame = 0.29;
  corner.translate = {0.4, 0.3, 0.0};
  close.frame = 1.0;
  close.translate = {-0.2, -0.3, 0.0};
  scene.objects[0].transform.keys = {open, corner, close};
  EXPECT_GE(psnr_of(scene, "a ball that turns back"), 70.0);
  EXPECT_EQ(segments_of(scene), 2.0);
}

/// A segment had the pixel filter of its middle however near its ends were.
TEST(ExactDefaults, DiscsThatFlyThrough) {
  Scene scene = test::stage();
  scene.film = {128, 96, 0, 0, 0, 0};
  Object object;
  test::Random random(4);
  for (int i = 0; i < 250; ++i) {
    test::add_disc(object, random.vector(-1.5, 1.5), random.vector(-1.0, 1.0).normalized(), random(0.01, 0.1),
                   random.vector(0.0, 1.0).cast<float>());
    object.cloud.velocity.emplace_back(0.3f, 0.1f, static_cast<float>(random(1.0, 3.0)));
  }
  scene.objects = {object};
  EXPECT_GE(psnr_of(scene, "discs that come by"), 70.0);
  EXPECT_GT(segments_of(scene), 2.0);
  Scene alike = scene;
  alike.model.segments = 1;
  EXPECT_LT(psnr_of(alike, "the same in one segment"), 60.0);
}

/// What moves straight and stays as far away keeps its one segment, and the bits that it has with it; without
/// a pixel filter, which depends on where a disc is seen from.
TEST(ExactDefaults, StraightMotionIsOneSegment) {
  Scene scene = ball();
  scene.model.filter_radius_px = 0.0;
  test::move(scene.objects[0], {-0.4, 0.1, 0.0}, {0.5, 0.2, 0.1});
  EXPECT_FALSE(cuts_by_point(scene, scene.objects[0], scene.exposure()));
  scene.objects.push_back(test::checkered_sphere(0.5, 300));
  for (std::size_t i = 0; i < 300; ++i) scene.objects[1].cloud.velocity.emplace_back(0.7f, -0.3f, 0.1f);
  EXPECT_FALSE(cuts_by_point(scene, scene.objects[1], scene.exposure()));
  EXPECT_EQ(segments_of(scene), 1.0);

  // A camera that moves beside does not turn.
  scene.camera.look_ats.push_back(scene.camera.look_ats[0]);
  scene.camera.look_ats[1].frame = 1.0;
  scene.camera.look_ats[1].eye.x() += 0.2;
  scene.camera.look_ats[1].target.x() += 0.2;
  EXPECT_FALSE(cuts_by_point(scene, scene.objects[1], scene.exposure()));

  // Among points that are cut one by one those that go straight keep their bits, too.
  const auto together = render_abuffer(scene, {});
  scene.motion.tolerance_px = 0.1;
  EXPECT_TRUE(cuts_by_point(scene, scene.objects[1], scene.exposure()));
  const auto by_point = render_abuffer(scene, {});
  ASSERT_TRUE(together.ok() && by_point.ok());
  EXPECT_EQ(together->image.rgba, by_point->image.rgba);
}

/// One segment each had the filtered disc that is seen in its middle.
TEST(ExactDefaults, StraightMotionIsSeenFromAside) {
  Scene scene = ball();
  test::move(scene.objects[0], {-0.4, 0.1, 0.0}, {0.5, 0.2, 0.0});
  EXPECT_TRUE(cuts_by_point(scene, scene.objects[0], scene.exposure()));
  const double seen = psnr_of(scene, "straight");
  Scene alike = scene;
  alike.model.segments = 1;
  EXPECT_GE(seen, 70.0);
  EXPECT_GE(seen, psnr_of(alike, "straight, the middle's filter") + 6.0);
  // What hardly moves is seen from one place.
  test::move(scene.objects[0], {-0.02, 0.1, 0.0}, {0.02, 0.1, 0.0});
  EXPECT_FALSE(cuts_by_point(scene, scene.objects[0], scene.exposure()));
}

}  // namespace
}  // namespace swept
