// The sampled method's traversals: none changes a bit of its image, and the one that is chosen is forecast.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stochastic_scenes.h"

namespace swept {
namespace {

using test::add_lens, test::expect_same_images, test::rendered, test::soup, test::soup_scene;

TEST(Stochastic, AllTraversalsAreOneImage) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Scene scene = soup_scene(seed, seed % 2 == 0);
    scene.objects[0].two_sided = seed % 3 != 0;
    if (seed % 3 == 1) add_lens(scene);
    if (seed == 5) scene.shutter.curve = ShutterShape::trapezoid;
    if (seed == 4) scene.objects.push_back(test::checkered_sphere(0.8, 200));
    expect_same_images(scene, 24, seed % 2 == 0 ? 40 : 0, "soup");
  }
}

TEST(Stochastic, AllTraversalsAreOneImageOfDiscs) {
  Scene scene = test::busy_scene();
  expect_same_images(scene, 16, 0, "discs");
  add_lens(scene);
  expect_same_images(scene, 16, 64, "discs through a lens");
}

/// Corners on a coarse grid: edges along rays, triangles without an area, equal depths, the near plane.
TEST(Stochastic, AllTraversalsAreOneImageOnAGrid) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Scene scene = test::stage();
    scene.objects = {soup(40, seed, seed % 2 == 0)};
    Object& object = scene.objects[0];
    PointArray<Eigen::Vector3d> position;
    for (const Eigen::Vector3d& p : object.cloud.keys[0].pose.position)
      position.push_back((p * 4.0).array().round() / 4.0);
    object.cloud.keys[0].pose.position = position;
    if (seed > 2) object.cloud.velocity.clear();
    scene.camera.near = 0.25;
    expect_same_images(scene, 16, 32, "grid");
  }
}

TEST(Stochastic, CountsWhatItTests) {
  const Scene scene = soup_scene(31, false);
  double last = 0.0;
  for (const int intervals : {1, 8, 64}) {
    const Statistics counts =
        rendered(scene, {.samples = 64, .traversal = Traversal::interval, .intervals = intervals}).statistics;
    const double efficiency = *counts.counter("sample_test_efficiency");
    EXPECT_EQ(efficiency, *counts.counter("samples_inside") / *counts.counter("samples_tested"));
    EXPECT_GT(efficiency, last) << intervals;
    last = efficiency;
  }
  // Small tiles and tight bounds test least.
  const auto tested = [&](int px, CurveBounds bounds) {
    return *rendered(scene, {.samples = 64, .traversal = Traversal::tile, .tile_px = px, .bounds = bounds})
                .statistics.counter("samples_tested");
  };
  EXPECT_LT(tested(1, CurveBounds::slefes), tested(4, CurveBounds::slefes));
  EXPECT_LT(tested(1, CurveBounds::slefes), tested(1, CurveBounds::hulls));
}

TEST(Stochastic, SaysThatABuildLacksTheHierarchy) {
  const auto result = render_stochastic(test::stage(), {.samples = 1, .traversal = Traversal::hierarchy});
  EXPECT_EQ(result.ok(), hierarchy_available());
  if (hierarchy_available()) return;
  EXPECT_EQ(result.error().kind, ErrorKind::unsupported);
  EXPECT_NE(result.error().message().find("SWEPT_HIERARCHY"), std::string::npos);
}

/// Triangles of a pixel or two, which go some way or none.
Scene small_triangles(double velocity) {
  Scene scene = test::stage();
  Object& object = scene.objects.emplace_back();
  object.cloud.keys.resize(1);
  SurfelPose& pose = object.cloud.keys[0].pose;
  for (std::uint32_t t = 0; t < 200; ++t) {
    const double x = 0.1 * (t % 20) - 1.0, y = 0.1 * (t / 20) - 0.5, a = 0.7 * t;
    for (const double corner : {0.0, 2.0, 4.0}) {
      pose.position.push_back({x + 0.06 * std::cos(corner), y + 0.06 * std::sin(corner), 0.0});
      pose.axis_u.emplace_back(0.01f, 0.0f, 0.0f);
      pose.axis_v.emplace_back(0.0f, 0.01f, 0.0f);
      object.cloud.velocity.emplace_back(static_cast<float>(velocity * std::cos(a)),
                                         static_cast<float>(velocity * std::sin(a)), 0.0f);
    }
    object.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  object.two_sided = true;
  return scene;
}

TEST(Stochastic, ChoosesItsTraversalByAForecast) {
  for (const double velocity : {0.0, 0.6}) {
    const Scene scene = small_triangles(velocity);
    const Rendered chosen = rendered(scene, {.samples = 64}), again = rendered(scene, {.samples = 64}, 1);
    const double tile = *chosen.statistics.counter("forecast_tile_us"),
                 interval = *chosen.statistics.counter("forecast_interval_us");
    EXPECT_GT(tile, 0.0);
    EXPECT_EQ(interval<tile, velocity> 0.0) << tile << " " << interval;
    EXPECT_EQ(chosen.statistics.effects.back(), velocity > 0.0
                                                    ? "traversal: 16 parts of the exposure, by a forecast"
                                                    : "traversal: 4 px tiles, by a forecast");
    EXPECT_EQ(tile, *again.statistics.counter("forecast_tile_us"));
    // What is asked for is not forecast.
    const Rendered asked = rendered(scene, {.samples = 64, .traversal = Traversal::tile});
    EXPECT_FALSE(asked.statistics.counter("forecast_tile_us").has_value());
    EXPECT_EQ(asked.statistics.effects.back(), "traversal: 4 px tiles");
    EXPECT_EQ(asked.image.rgba, chosen.image.rgba);
    if (velocity > 0.0) continue;
    EXPECT_EQ(asked.statistics.counter("samples_tested"), chosen.statistics.counter("samples_tested"));
  }
}

TEST(Stochastic, ForecastsOfNothingAreNothing) {
  Scene scene = small_triangles(0.0);
  scene.objects[0].transform.keys.resize(1);
  scene.objects[0].transform.keys[0].translate = {0.0, 100.0, 0.0};
  const Rendered none = rendered(scene, {.samples = 4});
  EXPECT_EQ(*none.statistics.counter("forecast_tile_us"), 0.0);
  EXPECT_EQ(*none.statistics.counter("samples_inside"), 0.0);
}

}  // namespace
}  // namespace swept
