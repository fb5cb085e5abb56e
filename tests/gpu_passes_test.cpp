// Each of the six passes looked at on its own: planted kernels whose answer is known, and random ones against
// the plain twin.
#include "gpu_pass_fixture.h"

#include <cmath>
#include <random>
#include <vector>

#include "gpu_compare.h"
#include "gpu_passes/six_pass/six_pass_twin.h"

namespace swept {
namespace {

TEST_F(GpuPasses, DepthAtOpenAndAtCloseKeepTheNearestDiscAndItsTolerance) {
  KernelSet set = stage_kernels();
  // At open over pixel 8, at close over pixel 23; a farther one stands still over both.
  set.kernels = {disc(16.0, 16.5, 100.0, 3.0, 15.0, red), disc(16.0, 16.5, 120.0, 14.0, 0.0, green)};
  set.kernels[1].depth_tolerance = 2.0f;
  draw(set, stage_scene());
  EXPECT_NEAR(at(Target::limit_open, 8, 16), 100.5, 100.5 * rounding);
  EXPECT_NEAR(at(Target::limit_close, 8, 16), 122.0, 122.0 * rounding);
  EXPECT_NEAR(at(Target::limit_open, 23, 16), 122.0, 122.0 * rounding);
  EXPECT_NEAR(at(Target::limit_close, 23, 16), 100.5, 100.5 * rounding);
  EXPECT_EQ(at(Target::limit_open, 0, 0), nowhere);
  EXPECT_EQ(at(Target::limit_close, 0, 0), nowhere);
}

TEST_F(GpuPasses, TheOrderOfKernelsDoesNotDecideWhichIsNearest) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.5, 16.5, 100.0, 3.0, 0.0, red), disc(16.5, 16.5, 90.0, 3.0, 0.0, green),
                 disc(16.5, 16.5, 110.0, 3.0, 0.0, blue)};
  draw(set, stage_scene());
  EXPECT_NEAR(at(Target::limit_open, 16, 16), 90.5, 90.5 * rounding);
}

TEST_F(GpuPasses, TimesAreThoseOfTheChordThroughTheDisc) {
  const double radius = 3.0, motion = 12.0;
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.0, 17.5, 100.0, radius, motion, red)};
  draw(set, stage_scene());
  // A row through the middle, and one 2 px beside it.
  for (const int y : {17, 19}) {
    const double half_chord = std::sqrt(radius * radius - (y - 17) * (y - 17));
    for (int x = 0; x < 32; ++x) {
      SCOPED_TRACE(testing::Message() << x << ", " << y);
      const double middle = 0.5 + (x + 0.5 - 16.0) / motion;
      const double first = std::max(0.0, middle - half_chord / motion);
      const double last = std::min(1.0, middle + half_chord / motion);
      if (first < last) {
        EXPECT_NEAR(at(Target::earliest, x, y), first, rounding);
        EXPECT_NEAR(at(Target::latest, x, y), last, rounding);
      } else {
        EXPECT_GT(at(Target::earliest, x, y), at(Target::latest, x, y));
      }
    }
  }
}

TEST_F(GpuPasses, SeveralKernelsGiveTheFirstAndTheLastTimeOfAll) {
  KernelSet set = stage_kernels();
  // 2 px radius, 16 px/shutter: over pixel 16 in τ ∈ [0.125, 0.375] and [0.625, 0.875].
  set.kernels = {disc(20.5, 16.5, 100.0, 2.0, 16.0, red), disc(12.5, 16.5, 100.0, 2.0, 16.0, green)};
  draw(set, stage_scene());
  EXPECT_NEAR(at(Target::earliest, 16, 16), 0.125, rounding);
  EXPECT_NEAR(at(Target::latest, 16, 16), 0.875, rounding);
  // Hard coverage: all the time between, though for half of it nothing is there.
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 3), 0.75, rounding);
}

TEST_F(GpuPasses, WhatIsHiddenAtBothEndsContributesNothing) {
  KernelSet set = stage_kernels();
  // Red covers the middle at open and leaves, blue arrives there at close; green behind is free in between.
  set.kernels = {disc(26.5, 16.5, 90.0, 3.0, 20.0, red), disc(6.5, 16.5, 90.0, 3.0, 20.0, blue),
                 disc(16.5, 16.5, 100.0, 3.0, 0.0, green)};
  draw(set, stage_scene());
  EXPECT_GT(at(Target::color_sum, 16, 16, 0), 0.0);
  EXPECT_EQ(at(Target::color_sum, 16, 16, 1), 0.0);
  EXPECT_GT(at(Target::color_sum, 16, 16, 2), 0.0);
  // Hard coverage has no use for it either.
  EXPECT_EQ(at(Target::behind_sum, 16, 16, 3), 0.0);
}

TEST_F(GpuPasses, WhatIsSeenAtOneEndContributesItsWholeIntegral) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(26.5, 16.5, 90.0, 3.0, 20.0, red), disc(16.5, 16.5, 100.0, 3.0, 0.0, green)};
  draw(set, stage_scene());
  // Green stands in the pixel's middle: ∫exp(0) = 1. Red passes over it for half a chord, 3 px of 20.
  EXPECT_NEAR(at(Target::color_sum, 16, 16, 1), 1.0, rounding);
  const double red_integral = 3.0 / 20.0 * 0.5 * std::sqrt(M_PI / 3.0) * std::erf(std::sqrt(3.0));
  EXPECT_NEAR(at(Target::color_sum, 16, 16, 0), red_integral, rounding);
  EXPECT_NEAR(at(Target::color_sum, 16, 16, 3), 1.0 + red_integral, rounding);
  EXPECT_NEAR(at(Target::depth_sum, 16, 16), 100.0 + 90.0 * red_integral, 200.0 * rounding);
}

TEST_F(GpuPasses, AKernelThatIsGoneInAnInstantKeepsItsDigits) {
  for (const double motion : {1e3, 1e4, 1e5, 1e6}) {
    SCOPED_TRACE(motion);
    KernelSet set = stage_kernels();
    set.kernels = {disc(16.5, 16.5, 100.0, 1.0, motion, red)};
    draw(set, stage_scene());
    // The whole chord through the middle: √(π/δ) erf(√δ) radii of the way.
    const double integral = std::sqrt(M_PI / 3.0) * std::erf(std::sqrt(3.0)) / motion;
    EXPECT_NEAR(at(Target::color_sum, 16, 16, 3), integral, integral * 4.0 * rounding);
    EXPECT_NEAR(at(Target::earliest, 16, 16), 0.5 - 1.0 / motion, rounding);
    EXPECT_EQ(at(Target::color_sum, 16, 18, 3), 0.0);
    EXPECT_GT(at(Target::color_sum, 0, 16, 3), 0.0);
    EXPECT_GT(at(Target::color_sum, 31, 16, 3), 0.0);
  }
}

TEST_F(GpuPasses, BackgroundSeenInTheMiddleButNotAtTheEndsIsLost) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(26.5, 16.5, 90.0, 3.0, 20.0, red), disc(6.5, 16.5, 90.0, 3.0, 20.0, blue)};
  Scene scene = stage_scene();
  scene.background = {0.0f, 8.0f, 0.0f, 1.0f};
  draw(set, scene);
  EXPECT_EQ(at(Target::earliest, 16, 16), 0.0);
  EXPECT_EQ(at(Target::latest, 16, 16), 1.0);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 0), 0.5, rounding);
  EXPECT_EQ(at(Target::frame_color, 16, 16, 1), 0.0);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 2), 0.5, rounding);
}

TEST_F(GpuPasses, NormalisationDividesByTheWeightsAndLeavesTheRestToTheBackground) {
  KernelSet set = stage_kernels();
  // Two discs of one surface, seen for the last quarter of the exposure.
  set.kernels = {disc(10.5, 16.5, 100.0, 2.0, 16.0, red), disc(10.5, 16.5, 100.2, 2.0, 16.0, green)};
  set.kernels[1].weight = 0.25f;
  Scene scene = stage_scene();
  scene.background = {0.0f, 0.0f, 2.0f, 1.0f};
  draw(set, scene);
  EXPECT_NEAR(at(Target::latest, 16, 16) - at(Target::earliest, 16, 16), 0.25, rounding);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 0), 0.25 * 0.8, rounding);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 1), 0.25 * 0.2, rounding);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 2), 0.75 * 2.0, rounding);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 3), 1.0, rounding);
  EXPECT_NEAR(at(Target::frame_depth, 16, 16, 0) / at(Target::frame_depth, 16, 16, 1),
              100.0 * 0.8 + 100.2 * 0.2, 100.0 * rounding);
  EXPECT_NEAR(at(Target::frame_color, 2, 2, 2), 2.0, rounding);
}

TEST_F(GpuPasses, SubframesAddUpByTheirSharesAndLeaveNothingToTheNext) {
  // A red disc in the first, half of the time, and a green one elsewhere in the second and in the third.
  std::vector<KernelSet> sets(4, stage_kernels());
  sets[0].kernels = {disc(13.0, 16.5, 100.0, 2.0, 8.0, red)};
  sets[1].kernels = sets[2].kernels = {disc(24.5, 16.5, 80.0, 2.0, 0.0, green)};
  Scene scene = stage_scene();
  scene.background = {0.0f, 0.0f, 2.0f, 1.0f};
  draw_all(sets, scene);
  // Pixel 12's chord is 4 px of 8.
  EXPECT_NEAR(at(Target::frame_color, 12, 16, 0), 0.5 / 4.0, rounding);
  EXPECT_NEAR(at(Target::frame_color, 12, 16, 2), 2.0 * 3.5 / 4.0, 2.0 * rounding);
  EXPECT_NEAR(at(Target::frame_color, 12, 16, 3), 1.0, rounding);
  EXPECT_NEAR(at(Target::frame_depth, 12, 16, 0), 100.0 * 0.5 / 4.0, 100.0 * rounding);
  EXPECT_NEAR(at(Target::frame_depth, 12, 16, 1), 0.5 / 4.0, rounding);
  EXPECT_NEAR(at(Target::frame_color, 24, 16, 1), 0.5, rounding);
  EXPECT_NEAR(at(Target::frame_depth, 24, 16, 0), 80.0 * 0.5, 80.0 * rounding);
  for (const int x : {12, 24}) {
    EXPECT_EQ(at(Target::limit_open, x, 16), nowhere);
    EXPECT_EQ(at(Target::limit_close, x, 16), nowhere);
    EXPECT_GT(at(Target::earliest, x, 16), at(Target::latest, x, 16));
    EXPECT_EQ(at(Target::color_sum, x, 16, 3), 0.0);
    EXPECT_EQ(at(Target::depth_sum, x, 16), 0.0);
  }
}

TEST_F(GpuPasses, SoftCoverageIsThatOfTheMeanKernelSum) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.5, 16.5, 100.0, 2.0, 0.0, red)};
  set.kernels[0].weight = 0.2f;
  Scene scene = stage_scene();
  scene.model.coverage = Coverage::soft;
  scene.model.edge_weight = 0.5;
  draw(set, scene);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 3), 0.4, rounding);
  // 1 px beside: exp(−δ/4).
  EXPECT_NEAR(at(Target::frame_color, 17, 16, 3), 0.4 * std::exp(-0.75), rounding);
}

TEST_F(GpuPasses, ASoftEdgeShowsWhatIsHiddenBehindItAndThenTheBackground) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.5, 16.5, 100.0, 2.0, 0.0, red), disc(16.5, 16.5, 110.0, 2.0, 0.0, green)};
  set.kernels[0].weight = 0.2f;
  set.kernels[1].weight = 0.3f;
  Scene scene = stage_scene();
  scene.background = {0.0f, 0.0f, 1.0f, 1.0f};
  scene.model.coverage = Coverage::soft;
  scene.model.edge_weight = 0.5;
  draw(set, scene);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 0), 0.4, rounding);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 1), 0.6 * 0.6, rounding);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 2), 0.6 * 0.4, rounding);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 3), 1.0, rounding);
  EXPECT_NEAR(at(Target::frame_depth, 16, 16, 0), 0.4 * 100.0 + 0.36 * 110.0, 100.0 * rounding);

  // Nothing of it through a surface that covers the pixel.
  set.kernels[0].weight = 0.5f;
  draw(set, scene);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 0), 1.0, rounding);
  EXPECT_NEAR(at(Target::frame_color, 16, 16, 1), 0.0, rounding);
}

TEST_F(GpuPasses, WhatComesNearerThanTheNearPlaneIsCutInTime) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.5, 16.5, 6.0, 12.0, 0.0, red)};
  set.near = 4.0;
  set.kernels[0].velocity = {0.0, 0.0, -8.0};  // from depth 10 to 2; at 4 when τ = 3/4
  draw(set, stage_scene());
  EXPECT_EQ(at(Target::earliest, 16, 16), 0.0);
  EXPECT_NEAR(at(Target::latest, 16, 16), 0.75, rounding);
  EXPECT_NEAR(at(Target::limit_open, 16, 16), 10.5, 10.5 * rounding);
  EXPECT_EQ(at(Target::limit_close, 16, 16), nowhere);
}

TEST_F(GpuPasses, WhatStandsNearerThanTheNearPlaneIsNotSeen) {
  KernelSet set = stage_kernels();
  set.near = 4.0;
  // Tilted, so that the near plane cuts it across the diagonal: its box holds pixels of both sides.
  set.kernels = {disc(16.0, 16.0, 4.0, 7.5, 0.0, red)};
  set.kernels[0].axis_u.z() = set.kernels[0].axis_u.x();
  set.kernels[0].axis_v.z() = set.kernels[0].axis_v.y();
  draw(set, stage_scene());
  for (int y = 12; y < 20; ++y)
    for (int x = 12; x < 20; ++x) {
      SCOPED_TRACE(testing::Message() << x << ", " << y);
      if (x + y == 31) continue;  // on the plane
      const bool seen = x + y > 31;
      EXPECT_EQ(at(Target::limit_open, x, y) < nowhere, seen);
      EXPECT_EQ(at(Target::earliest, x, y), seen ? 0.0 : 2.0);
      EXPECT_EQ(at(Target::latest, x, y), seen ? 1.0 : -1.0);
      EXPECT_EQ(at(Target::color_sum, x, y, 3) > 0.0, seen);
    }
}

/// Discs of all attitudes, moving in all directions, in their planes too, some through the near plane.
KernelSet random_kernels(unsigned seed, int count, double motion) {
  std::mt19937 engine(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 8) * 0x1p-24;
  };
  const auto direction = [&] { return Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)); };
  KernelSet set = stage_kernels();
  for (int i = 0; i < count; ++i) {
    MovingKernel kernel = disc(uniform(-4, 36), uniform(-4, 36), uniform(20, 60), 1.0, 0.0, red);
    kernel.axis_u = (uniform(0.3, 2.0) * direction().normalized()).cast<float>();
    kernel.axis_v = (uniform(0.3, 2.0) * direction().normalized()).cast<float>();
    kernel.velocity = motion * direction();
    if (i % 4 == 0)
      kernel.velocity =
          motion * (uniform(-1, 1) * kernel.axis_u + uniform(-1, 1) * kernel.axis_v).cast<double>();
    if (i % 4 == 1) kernel.velocity = motion * uniform(-1, 1) * kernel.center.normalized();
    if (i % 4 == 2) kernel.velocity.setZero();
    if (i % 3 == 0) kernel.facing = kernel.axis_u.cross(kernel.axis_v).normalized();
    kernel.depth_tolerance = static_cast<float>(uniform(0.1, 2.0));
    kernel.weight = static_cast<float>(uniform(0.1, 1.0));
    kernel.color.head<3>() =
        Eigen::Vector3f(static_cast<float>(uniform(0, 1)), static_cast<float>(uniform(0, 1)),
                        static_cast<float>(uniform(0, 1)));
    set.kernels.push_back(kernel);
  }
  set.near = 25.0;
  return set;
}

TEST_F(GpuPasses, EveryTargetEqualsThatOfThePlainTwin) {
  for (const double motion : {0.0, 1e-4, 0.3, 10.0}) {
    SCOPED_TRACE(motion);
    const KernelSet set = random_kernels(7, 300, motion);
    Scene scene = stage_scene();
    scene.camera.near = set.near;
    scene.model.coverage = Coverage::soft;
    draw(set, scene);
    EXPECT_GT(batches(), 1u);
    TwinTargets twin = twin_passes(set, scene, GpuMethod::six_pass);
    for (std::vector<double>* limit : {&twin.limit_open, &twin.limit_close})
      for (double& value : *limit) value = std::min(value, nowhere);

    // Distances in the disc's plane are in radii: up to 40 px of offset, an axis of 0.3 px, foreshortened
    // tenfold in places, six roundings of 2⁻²⁴: e = 40/0.3 · 10 · 6 · 2⁻²⁴ = 5e-4 at the worst, and a
    // hundredth of it where discs are seen face on and near their middle. Kernels change by 2δ e = 6 e. A
    // fragment falls on the other side of a cut-off within e of it: in the worst of cases 300 discs × 5e-4 of
    // all.
    const double e = 5e-6;
    EXPECT_TRUE(equal_within(runner().read(Target::limit_open), twin.limit_open, 1, {60.0 * e, 0.01}));
    EXPECT_TRUE(equal_within(runner().read(Target::limit_close), twin.limit_close, 1, {60.0 * e, 0.01}));
    EXPECT_TRUE(equal_within(runner().read(Target::earliest), twin.earliest, 1, {20.0 * e, 0.01}));
    EXPECT_TRUE(equal_within(runner().read(Target::latest), twin.latest, 1, {20.0 * e, 0.01}));
    EXPECT_TRUE(equal_within(runner().read(Target::color_sum), twin.color_sum, 4, {6.0 * e, 0.01}));
    EXPECT_TRUE(equal_within(runner().read(Target::behind_sum), twin.behind_sum, 4, {6.0 * e, 0.01}));
    EXPECT_TRUE(equal_within(runner().read(Target::depth_sum), twin.depth_sum, 2, {60.0 * 6.0 * e, 0.01}));
  }
}

TEST_F(GpuPasses, BatchesChangeNoBit) {
  const KernelSet set = random_kernels(11, 300, 5.0);
  const Scene scene = stage_scene();
  draw(set, scene);
  EXPECT_GT(batches(), 2u);
  const std::vector<float> in_batches = runner().read(Target::color_sum);
  Result<PassRunner> other = PassRunner::create(1000);
  ASSERT_TRUE(other);
  ASSERT_TRUE(other->begin_frame(stage_setup(set, scene, six_passes())));
  other->draw_subframe(make_instances(set, {0, 0, 32, 32}));
  const Result<DrawnFrame> frame = other->end_frame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->batches, 1u);
  EXPECT_EQ(other->read(Target::color_sum), in_batches);
}

TEST_F(GpuPasses, EveryPassIsTimed) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.0, 16.5, 100.0, 10.0, 8.0, red)};
  draw(set, stage_scene());
  ASSERT_EQ(seconds().size(), 6u);
  double total = 0.0;
  for (const double value : seconds()) total += value;
  EXPECT_GT(total, 0.0);
  EXPECT_LT(total, 10.0);
}

}  // namespace
}  // namespace swept
