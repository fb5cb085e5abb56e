// Every hard case of model section 10 as a scene: the exact renderer against the reference, with half of
// the stills that tools/hard-cases takes. That one also draws them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "tests/counter.h"
#include "tests/image_difference.h"
#include "tests/oracle/hard_scenes.h"

namespace swept {
namespace {

using test::counter;

const oracle::HardScene& scene_named(const std::string& name) {
  for (const oracle::HardScene& hard : oracle::hard_scenes())
    if (hard.name == name) return hard;
  ADD_FAILURE() << "no scene " << name;
  return oracle::hard_scenes().front();
}

class HardSceneTest : public testing::TestWithParam<oracle::HardScene> {};

TEST_P(HardSceneTest, IsTheReference) {
  const oracle::HardScene& hard = GetParam();
  Scene scene = hard.make();
  scene.background.setZero();
  const auto rendered = render_abuffer(scene, {.parabolas = false});
  ASSERT_TRUE(rendered.ok()) << rendered.error().message();
  const int samples = std::max(2, hard.samples / 2);
  const auto reference = render_reference(scene, {samples, ReferenceMotion::segments});
  ASSERT_TRUE(reference.ok()) << reference.error().message();
  const std::vector<float>& truth = reference->image.rgba;
  EXPECT_GT(*std::max_element(truth.begin(), truth.end()), 0.05f) << "there is nothing to see";
  const test::ImageDifference off = test::difference_of(rendered->image, reference->image);
  const double required = std::pow(10.0, -hard.required_db / 20.0);
  EXPECT_LE(off.color, required);
  EXPECT_LE(off.depth, hard.required_depth);
  EXPECT_LE(counter(*reference, "reference_error_rmse"), 0.7 * required)
      << "the reference is too coarse to judge";
  // Parabolas come nearer to the true path than the chords of the same scene.
  const auto bent = render_abuffer(scene);
  ASSERT_TRUE(bent.ok()) << bent.error().message();
  if (bent->image.rgba == rendered->image.rgba) return;
  const auto smooth = render_reference(scene, {samples, ReferenceMotion::smooth});
  ASSERT_TRUE(smooth.ok()) << smooth.error().message();
  const test::ImageDifference chords_off = test::difference_of(rendered->image, smooth->image),
                              bent_off = test::difference_of(bent->image, smooth->image);
  // Or as near: where discs are enormous both have the errors of how they are resolved.
  EXPECT_LE(bent_off.color, std::max(required, 1.01 * chords_off.color));
  EXPECT_LE(bent_off.depth, std::max(hard.required_depth, 1.01 * chords_off.depth));
}

INSTANTIATE_TEST_SUITE_P(HardScenes, HardSceneTest, testing::ValuesIn(oracle::hard_scenes()),
                         [](const auto& param) {
                           std::string name = param.param.name;
                           for (char& c : name)
                             if (c == '-') c = '_';
                           return name;
                         });

/// Bit for bit, and where everything moves.
TEST(HardScene, AClosedShutterIsTheStillImage) {
  const Scene closed = scene_named("closed_shutter").make();
  Scene still = closed;
  for (Object& object : still.objects) {
    for (std::size_t i = 0; i < object.cloud.size(); ++i)
      object.cloud.keys[0].pose.position[i] += 0.1 * object.cloud.velocity[i].cast<double>();
    object.cloud.velocity.clear();
  }
  still.shutter = {-0.5, 0.5};
  const auto a = render_abuffer(closed), b = render_abuffer(still);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->image.rgba, b->image.rgba);
  EXPECT_EQ(a->image.depth, b->image.depth);
}

/// 5,000 km away coordinates are rounded by 2⁻³¹ m, a hundred-millionth of a pixel here.
TEST(HardScene, FarFromTheOriginIsTheSamePicture) {
  const auto near = render_abuffer(scene_named("motion_in_plane").make());
  const auto far = render_abuffer(scene_named("far_from_origin").make());
  ASSERT_TRUE(near && far);
  double worst = 0.0;
  for (std::size_t i = 0; i < near->image.rgba.size(); ++i)
    worst = std::max<double>(worst, std::abs(near->image.rgba[i] - far->image.rgba[i]));
  // A pixel's colour changes by at most δ-ish 5 per radius moved, a radius being at least 0.06 here; and
  // events that come in another order split pieces elsewhere, which is worth what a piece is cut for.
  EXPECT_LE(worst, 2 * 0x1p-31 * 5.0 / 0.06 + 0x1p-12);
}

/// Degenerate discs show nothing, whatever else there is.
TEST(HardScene, DiscsWithoutAreaChangeNoBit) {
  const auto without = render_abuffer(scene_named("motion_in_plane").make());
  for (const char* name : {"axis_of_length_zero", "parallel_axes"}) {
    const auto with = render_abuffer(scene_named(name).make());
    ASSERT_TRUE(without && with);
    EXPECT_EQ(without->image.rgba, with->image.rgba) << name;
    EXPECT_EQ(counter(*with, "culled_degenerate"), 2.0) << name;
  }
}

/// NaN and infinity are refused, with the array and the index.
TEST(HardScene, WhatIsNotFiniteIsAnError) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const float bad_float = static_cast<float>(bad);
    for (int field = 0; field < 5; ++field) {
      Scene scene = scene_named("motion_in_plane").make();
      SurfelCloud& cloud = scene.objects[1].cloud;
      SurfelPose& pose = cloud.keys[0].pose;
      if (field == 0) pose.position[7].y() = bad;
      if (field == 1) pose.axis_u[7].y() = bad_float;
      if (field == 2) pose.axis_v[7].y() = bad_float;
      if (field == 3) cloud.velocity[7].y() = bad_float;
      if (field == 4) cloud.color[7].y() = bad_float;
      const auto rendered = render_abuffer(scene);
      ASSERT_FALSE(rendered.ok()) << field;
      EXPECT_NE(rendered.error().message().find('7'), std::string::npos) << rendered.error().message();
    }
  }
}

}  // namespace
}  // namespace swept
