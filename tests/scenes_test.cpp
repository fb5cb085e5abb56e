// The generated scenes, small: the exact renderer against the reference, and no silent fall into a rare
// branch.
#include <cmath>
#include <numeric>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "datasets/generators.h"
#include "splat/io/scene_file.h"
#include "tests/counter.h"
#include "tests/image_difference.h"

namespace swept {
namespace {

using test::counter;

/// Twice what rare branches were when this was written, and nothing where there was nothing. Shares of
/// kernels, of intervals and of fragments.
struct Ceilings {
  double edge_on, at_near_plane, subdivided, crossings, at_shortest, revealed;
};

struct Case {
  const char* name;
  Ceilings most;
  /// Where most discs turn from key to key they are cut to be as the true path has them, not as chords.
  ReferenceMotion motion = ReferenceMotion::segments;

  friend void PrintTo(const Case& scene, std::ostream* out) { *out << scene.name; }
};

constexpr Case cases[] = {{"default", {7e-4, 5e-3, 0.051, 0.03, 3e-4, 4e-3}},
                          {"knot", {1.5e-3, 0.0, 0.17, 0.034, 2.4e-4, 2e-3}},
                          {"heads", {1.5e-3, 0.0, 0.18, 0.17, 0.038, 8e-3}},
                          {"page", {0.0, 0.0, 0.036, 0.0, 0.0, 0.0}},
                          {"overlap", {1e-3, 0.0, 0.16, 0.094, 0.027, 6e-3}},
                          {"both_ends", {1.4e-3, 0.0, 0.17, 0.054, 0.01, 0.025}, ReferenceMotion::smooth},
                          {"still", {7e-4, 0.0, 0.0, 0.0, 0.0, 0.0}}};

class GeneratedScene : public testing::TestWithParam<Case> {};

TEST_P(GeneratedScene, IsTheReferenceToEightyDecibels) {
  SceneOverrides overrides;
  overrides.fields = {{"/film/width", {120}}, {"/film/height", {80}}};
  overrides.points_scale = 0.08;
  const std::string path = std::string(SWEPT_SCENES) + "/" + GetParam().name + ".json";
  auto file = read_scene_file(path, overrides);
  ASSERT_TRUE(file.ok()) << file.error().message();
  auto scene = file->scene_at(file->scene().frame, generate);
  ASSERT_TRUE(scene.ok()) << scene.error().message();

  Scene seen = **scene;
  seen.background.setZero();
  auto rendered = render_abuffer(seen);
  ASSERT_TRUE(rendered.ok()) << rendered.error().message();
  auto reference = render_reference(seen, {256, GetParam().motion});
  ASSERT_TRUE(reference.ok()) << reference.error().message();

  const std::vector<float>& truth = reference->image.rgba;
  const double signal = std::accumulate(truth.begin(), truth.end(), 0.0) / static_cast<double>(truth.size());
  EXPECT_GT(signal, 0.02) << "there is nothing to see";
  const test::ImageDifference off = test::difference_of(rendered->image, reference->image);
  // 80 dB, on top of what the reference is off by itself; its estimate is within a factor of √1.5.
  const double own = counter(*reference, "reference_error_rmse");
  EXPECT_LT(off.color, std::hypot(1e-4, 1.5 * own)) << own;
  EXPECT_LT(own, 4e-4) << "the reference is too coarse to judge";
  // An edge's time is off by a still's share of the exposure: 1/√12 of 1/256 in root mean square. At no more
  // than a tenth of all pixels there is an edge.
  EXPECT_LT(off.depth, 1.2e-4);

  const double kernels = counter(*rendered, "kernels"), fragments = counter(*rendered, "fragments");
  EXPECT_LE(counter(*rendered, "culled_degenerate"), 1e-3 * kernels);
  const Ceilings& most = GetParam().most;
  EXPECT_LE(counter(*rendered, "kernels_edge_on"), most.edge_on * kernels);
  EXPECT_LE(counter(*rendered, "kernels_at_near_plane"), most.at_near_plane * kernels);
  const double intervals = counter(*rendered, "intervals");
  EXPECT_LE(counter(*rendered, "intervals_subdivided"), most.subdivided * intervals);
  EXPECT_LE(counter(*rendered, "intervals_cut_by_crossings"), most.crossings * intervals);
  EXPECT_LE(counter(*rendered, "intervals_at_shortest"), most.at_shortest * intervals);
  EXPECT_LE(counter(*rendered, "hidden_revealed"), most.revealed * fragments);
}

INSTANTIATE_TEST_SUITE_P(Scenes, GeneratedScene, testing::ValuesIn(cases),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace swept
