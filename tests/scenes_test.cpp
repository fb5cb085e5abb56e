// The generated scenes, small: the exact renderer against the reference, and no silent fall into a rare
// branch.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference.h"
#include "datasets/generators.h"
#include "splat/io/scene_file.h"

namespace swept {
namespace {

double counter(const Rendered& rendered, const std::string& name) {
  for (const auto& [key, value] : rendered.statistics.counters)
    if (key == name) return value;
  ADD_FAILURE() << "no counter " << name;
  return 0.0;
}

class GeneratedScene : public testing::TestWithParam<const char*> {};

TEST_P(GeneratedScene, IsTheReferenceToEightyDecibels) {
  SceneOverrides overrides;
  overrides.size = {120, 80};
  overrides.points_scale = 0.08;
  const std::string path = std::string(SWEPT_SCENES) + "/" + GetParam() + ".json";
  auto file = read_scene_file(path, overrides);
  ASSERT_TRUE(file.ok()) << file.error().message();
  auto scene = file->scene_at(file->scene().frame, generate);
  ASSERT_TRUE(scene.ok()) << scene.error().message();

  auto rendered = render_abuffer(**scene);
  ASSERT_TRUE(rendered.ok()) << rendered.error().message();
  auto reference = render_reference(**scene, {256, 0, ReferenceMotion::segments});
  ASSERT_TRUE(reference.ok()) << reference.error().message();

  double sum = 0.0, signal = 0.0;
  const std::vector<float>&a = rendered->image.rgba, &b = reference->image.rgba;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2);
    signal += std::abs(static_cast<double>(b[i]));
  }
  EXPECT_GT(signal / static_cast<double>(a.size()), 0.02) << "there is nothing to see";
  // 80 dB, on top of what the reference is off by itself; its estimate is within a factor of √1.5.
  const double own = counter(*reference, "reference_error_rmse");
  EXPECT_LT(std::sqrt(sum / static_cast<double>(a.size())), std::hypot(1e-4, 1.5 * own)) << own;
  EXPECT_LT(own, 4e-4) << "the reference is too coarse to judge";

  const double kernels = counter(*rendered, "kernels"), fragments = counter(*rendered, "fragments");
  EXPECT_LE(counter(*rendered, "culled_degenerate"), 1e-3 * kernels);
  EXPECT_LE(counter(*rendered, "intervals_subdivided"), fragments);
  EXPECT_LE(counter(*rendered, "hidden_revealed"), 0.1 * fragments);
}

INSTANTIATE_TEST_SUITE_P(Scenes, GeneratedScene,
                         testing::Values("default", "knot", "heads", "page", "overlap", "both_ends", "still"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace swept
