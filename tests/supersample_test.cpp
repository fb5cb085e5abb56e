// The mean of still images by the production still path, against the reference that shares no code with it.
#include "abuffer/supersample.h"

#include <cmath>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "datasets/generators.h"
#include "tests/counter.h"

namespace swept {
namespace {

using test::counter;

/// A ball that turns half round and crosses a third of the film while the shutter is open.
Scene turning_ball() {
  Scene scene;
  scene.film = {96, 64, 0, 0, 0, 0};
  scene.camera.look_ats.emplace_back();
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  scene.shutter = {-0.5, 0.5};
  Object& object = scene.objects.emplace_back();
  auto cloud = generate("sphere", 600, {});
  EXPECT_TRUE(cloud.ok());
  object.cloud = std::move(*cloud);
  object.transform.keys.resize(2);
  object.transform.keys[0].frame = -0.5;
  object.transform.keys[0].translate = {-0.7, 0.0, 0.0};
  object.transform.keys[1].frame = 0.5;
  object.transform.keys[1].translate = {0.7, 0.2, 0.5};
  object.transform.keys[1].rotate_radians = 2.0;
  return scene;
}

double largest_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    largest = std::max(largest, std::abs(static_cast<double>(a.rgba[i]) - static_cast<double>(b.rgba[i])));
  return largest;
}

TEST(Supersample, IsTheReferenceAtTheSameInstants) {
  const Scene scene = turning_ball();
  const auto stills = render_supersampled(scene, {8, 0});
  const auto reference = render_reference(scene, {8, 0, ReferenceMotion::smooth});
  ASSERT_TRUE(stills.ok() && reference.ok());
  EXPECT_EQ(counter(*stills, "instants"), 8.0);
  // Float against double. A fragment that only one of the two finds on its rim, e^−3 of a kernel in one of 8
  // instants, would be worth 0.003; none is here.
  EXPECT_LT(largest_difference(stills->image, reference->image), 2e-5);
  // The picture is not empty, and differs from its neighbours.
  const auto sixteen = render_supersampled(scene, {16, 0});
  ASSERT_TRUE(sixteen.ok());
  EXPECT_GT(largest_difference(stills->image, sixteen->image), 0.01);
}

TEST(Supersample, ConvergesToTheExactImage) {
  Scene scene = turning_ball();
  scene.model.segments = 64;
  const auto exact = render_abuffer(scene);
  ASSERT_TRUE(exact.ok());
  double before = 1.0;
  for (const int samples : {4, 16, 64}) {
    const auto stills = render_supersampled(scene, {samples, 0});
    ASSERT_TRUE(stills.ok());
    const double error = largest_difference(stills->image, exact->image);
    // Where a pixel's signal jumps the midpoint rule errs by up to a sample, so four times as many halve it
    // by far.
    EXPECT_LT(error, 0.5 * before) << samples;
    before = error;
  }
}

TEST(Supersample, TheSameBitsForAnyNumberOfThreads) {
  const Scene scene = turning_ball();
  const auto one = render_supersampled(scene, {4, 1}), three = render_supersampled(scene, {4, 3});
  ASSERT_TRUE(one.ok() && three.ok());
  EXPECT_EQ(one->image.rgba, three->image.rgba);
  EXPECT_EQ(one->image.depth, three->image.depth);
}

TEST(Supersample, WhatDoesNotMoveTakesOneStillImage) {
  Scene scene = turning_ball();
  scene.shutter = {0.25, 0.25};
  const auto stills = render_supersampled(scene, {1000, 0});
  const auto still = render_abuffer(scene);
  ASSERT_TRUE(stills.ok() && still.ok());
  EXPECT_EQ(counter(*stills, "instants"), 1.0);
  // The background is put behind a float here, and behind a double there.
  EXPECT_LT(largest_difference(stills->image, still->image), 2e-7);
}

TEST(Supersample, RefusesWhatIsOutOfRange) {
  const Scene scene = turning_ball();
  for (const SupersampleOptions& options : {SupersampleOptions{0, 0}, SupersampleOptions{1 << 21, 0}}) {
    const auto refused = render_supersampled(scene, options);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "samples");
  }
  EXPECT_EQ(render_supersampled(scene, {1, -1}).error().field, "threads");
}

}  // namespace
}  // namespace swept
