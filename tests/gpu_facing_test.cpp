// What is seen from behind is in none of the passes: not at open, not at close, not between.
#include "gpu_pass_fixture.h"

namespace swept {
namespace {

/// A disc at depth 90 that crosses the film from pixel 8 at open to pixel 23 at close, seen from behind, in
/// front of one that stands still; both soft, so that hidden kernels count too.
TEST_F(GpuPasses, ADiscSeenFromBehindIsInNoneOfThem) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.0, 16.5, 90.0, 3.0, 15.0, red), disc(16.0, 16.5, 100.0, 14.0, 0.0, green)};
  set.kernels[0].facing = {0.0f, 0.0f, 1.0f};
  Scene scene = stage_scene();
  scene.model.coverage = Coverage::soft;
  draw(set, scene);
  const std::vector<Target> targets{Target::limit_open, Target::limit_close, Target::earliest,
                                    Target::latest,     Target::color_sum,   Target::behind_sum,
                                    Target::depth_sum,  Target::frame_color, Target::frame_depth};
  std::vector<std::vector<float>> from_behind;
  for (const Target target : targets) from_behind.push_back(runner().read(target));
  set.kernels.erase(set.kernels.begin());
  draw(set, scene);
  for (std::size_t i = 0; i < targets.size(); ++i) EXPECT_EQ(runner().read(targets[i]), from_behind[i]) << i;

  // Seen from its front it is in each of the passes: at both ends, first, last, and in the sums.
  set.kernels.insert(set.kernels.begin(), disc(16.0, 16.5, 90.0, 3.0, 15.0, red));
  set.kernels[0].facing = {0.0f, 0.0f, -1.0f};
  draw(set, scene);
  EXPECT_NEAR(at(Target::limit_open, 8, 16), 90.5, 90.5 * rounding);
  EXPECT_NEAR(at(Target::limit_close, 23, 16), 90.5, 90.5 * rounding);
  EXPECT_GT(at(Target::color_sum, 8, 16, 0), 0.0);
}

TEST_F(GpuPasses, ADiscSeenFromBehindHasNoTimes) {
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.0, 16.5, 100.0, 3.0, 15.0, red)};
  set.kernels[0].facing = {0.0f, 0.0f, 1.0f};
  draw(set, stage_scene());
  for (int x = 0; x < 32; ++x) {
    EXPECT_EQ(at(Target::limit_open, x, 16), nowhere) << x;
    EXPECT_EQ(at(Target::limit_close, x, 16), nowhere) << x;
    EXPECT_GT(at(Target::earliest, x, 16), 1.0) << x;
    EXPECT_LT(at(Target::latest, x, 16), 0.0) << x;
    EXPECT_EQ(at(Target::color_sum, x, 16, 3), 0.0) << x;
  }
}

TEST_F(GpuPasses, WhichSideOfADiscIsSeenIsAskedAlongEachRay) {
  // Facing left: from the eye, its front is seen along rays to the right of the axis.
  KernelSet set = stage_kernels();
  set.kernels = {disc(16.0, 16.5, 100.0, 9.0, 4.0, red)};
  set.kernels[0].facing = {-1.0f, 0.0f, 0.0f};
  draw(set, stage_scene());
  for (int x = 10; x < 22; ++x) {
    const bool seen = x >= 16;
    EXPECT_EQ(at(Target::limit_open, x, 16) < nowhere, seen) << x;
    EXPECT_EQ(at(Target::limit_close, x, 16) < nowhere, seen) << x;
    EXPECT_EQ(at(Target::earliest, x, 16) <= at(Target::latest, x, 16), seen) << x;
    EXPECT_EQ(at(Target::color_sum, x, 16, 3) > 0.0, seen) << x;
  }
}

}  // namespace
}  // namespace swept
