// Where surfaces of different meshes, or of a mesh and discs, pass through each other: all of it is found.
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/resolve/depth_changes.h"
#include "tests/drawn.h"
#include "tests/mesh_scenes.h"

namespace swept {
namespace {

using test::exact;
using test::rectangle;

std::vector<double> changes_of(const std::function<double(double)>& apart, double begin, double end) {
  std::vector<double> times;
  DepthChanges::Values seen{};
  DepthChanges::find(
      begin, end, 12, 1, [&](double time, std::size_t place) { seen[place] = apart(time); },
      [&](std::size_t) { return seen; }, [](std::size_t) { return 3.0; }, times);
  std::sort(times.begin(), times.end());
  return times;
}

TEST(DepthChanges, AreAllFoundHoweverNearEachOther) {
  std::mt19937_64 random(5);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (int i = 0; i < 10'000; ++i) {
    // Quotients, as the depths of triangles are.
    const double begin = uniform(), end = begin + std::pow(10.0, -uniform());
    const double a = begin + uniform() * (end - begin) * 0.9,
                 b = a + (end - begin) * std::min(0.09, std::pow(10.0, -1.0 - 4.0 * uniform()));
    const double pole = -0.1 - uniform();
    const auto found =
        changes_of([&](double t) { return 2.0 * (t - a) * (t - b) / (t - begin - pole); }, begin, end);
    ASSERT_EQ(found.size(), 2u) << i << " " << (b - a) / (end - begin);
    // What a polynomial may be off by, of the largest value, over the slope at the root.
    const double off = 100.0 * DepthChanges::off * (end - begin) * (end - begin) / (b - a);
    EXPECT_NEAR(found[0], a, off);
    EXPECT_NEAR(found[1], b, off);
  }
}

TEST(DepthChanges, AreNoneOfWhatIsOneDepthButForRounding) {
  EXPECT_TRUE(changes_of([](double t) { return 1e-15 * std::sin(1e6 * t); }, 0.0, 1.0).empty());
  EXPECT_TRUE(changes_of([](double t) { return (t - 0.3) * (t - 0.3) + 1e-6; }, 0.0, 1.0).empty());
}

constexpr double first = 3.0 / 16.0, last = first + 1.0 / 256.0;  // floats hold what is made of them

/// At a depth of 3 + 4 (t − first) (t − last).
Object passing() {
  Object red = rectangle({0, 0, 3.0 + 4.0 * first * last}, 9.0, 9.0, {1, 0, 0});
  test::move_points(red, {0, 0, static_cast<float>(-4.0 * (first + last))});
  red.cloud.acceleration.assign(4, {0, 0, 8});
  return red;
}

/// Both ends and the middle of the exposure have one order, which is another one for 1/256 of it.
TEST(DepthChanges, OfMeshesAreNotMissedWithinAShortTime) {
  for (const bool colors_vary : {false, true})
    for (const bool swapped : {false, true}) {
      Object red = passing(), blue = rectangle({0, 0, 3.0}, 9.0, 9.0, {0, 0, 1});
      // What looks at colours again and again must not be what finds it.
      if (colors_vary) red.cloud.color[0] = blue.cloud.color[0] = {1, 0, 1};
      Scene scene = test::mesh_stage(8, 6, 0.5);
      scene.objects = {red, blue};
      if (swapped) scene.objects = {blue, red};
      const Image image = exact(scene).image;
      for (std::size_t i = 0; i < image.pixel_count(); ++i) {
        if (colors_vary) {
          // Somewhere between the two pictures.
          Scene without = scene;
          without.objects = {blue};
          const double blue_alone = exact(without).image.rgba[4 * i];
          without.objects = {red};
          const double red_alone = exact(without).image.rgba[4 * i];
          ASSERT_NEAR(image.rgba[4 * i], blue_alone + (red_alone - blue_alone) / 256.0, 2e-6);
        } else {
          ASSERT_NEAR(image.rgba[4 * i], 1.0 / 256.0, 1e-6);
          ASSERT_NEAR(image.rgba[4 * i + 2], 255.0 / 256.0, 1e-6);
        }
      }
    }
}

TEST(DepthChanges, OfMeshAndDiscAreNotMissedWithinAShortTime) {
  Object disc;
  test::add_point(disc, {0, 0, 3.0}, {0, 0, 1}, 30.0f);
  Scene scene = test::mesh_stage(9, 9, 0.1);
  scene.objects = {passing(), disc};
  const Image image = exact(scene).image;
  const std::size_t middle = image.pixel_count() / 2;
  EXPECT_NEAR(image.rgba[4 * middle], 1.0 / 256.0, 1e-6);
  EXPECT_NEAR(image.rgba[4 * middle + 3], 1.0, 1e-6);
}

}  // namespace
}  // namespace swept
