// Front and back of a disc are two surfaces (model section 1.2), the same in every method that tells them
// apart.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/layers.h"
#include "abuffer/reference/reference.h"
#include "abuffer/reference/reference_frame.h"
#include "abuffer/resolve/still.h"
#include "abuffer/resolve/sweep.h"
#include "abuffer/simd/sampled_math.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

const Eigen::Vector3f red(1.0f, 0.0f, 0.0f), blue(0.0f, 0.0f, 1.0f);

using test::decibels, test::reference, test::sampled;

Image exact(const Scene& scene, const AbufferOptions& options = {}) {
  return test::exact(scene, options).image;
}

/// A sheet of discs in the plane z = 0: one layer red that faces +z at `gap`, one blue that faces −z at −gap.
Object sheet(double gap, int side = 12, double radius = 0.16) {
  Object object;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double x = 1.6 * (i + 0.5) / side - 0.8, y = 1.6 * (j + 0.5) / side - 0.8;
      test::add_disc(object, {x, y, gap}, {0, 0, 1}, radius, red);
      test::add_disc(object, {x, y, -gap}, {0, 0, -1}, radius, blue);
    }
  object.cloud.oriented.assign(object.cloud.size(), 1);
  return object;
}

Scene sheet_scene() {
  Scene scene = test::stage();
  scene.objects = {sheet(0.01)};
  return scene;
}

void expect_middle(const Image& image, const Eigen::Vector3f& color, double depth, const std::string& what) {
  const std::size_t middle = static_cast<std::size_t>(image.height / 2 * image.width + image.width / 2);
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(image.rgba[4 * middle + c], color[static_cast<int>(c)], 1e-6f) << what << ' ' << c;
  EXPECT_NEAR(image.depth[middle], depth, 1e-4) << what;
}

TEST(Sides, OfAThinSheetAreTwoSurfaces) {
  const Scene scene = sheet_scene();
  expect_middle(sampled(scene, 1), red, 4.99, "sampled");
  expect_middle(exact(scene), red, 4.99, "exact");
  expect_middle(reference(scene, 2), red, 4.99, "reference");
  AbufferOptions per_pixel;
  per_pixel.normalisation = Normalisation::pixel;
  expect_middle(exact(scene, per_pixel), red, 4.99, "per pixel");

  Scene moving = scene;
  test::move(moving.objects[0], {-0.05, 0.0, 0.0}, {0.05, 0.02, 0.0});
  expect_middle(sampled(moving, 8), red, 4.99, "sampled");
  expect_middle(exact(moving), red, 4.99, "exact");
  expect_middle(reference(moving, 8), red, 4.99, "reference");

  // From behind, and turned inside out by a mirror: the same sheet.
  Scene behind = scene;
  behind.camera.look_ats[0].eye = {0, 0, -5};
  expect_middle(sampled(behind, 1), blue, 4.99, "behind");
  Scene mirrored = moving;
  for (TransformKey& key : mirrored.objects[0].transform.keys) key.scale = {-1.0, 1.0, 1.0};
  expect_middle(sampled(mirrored, 8), red, 4.99, "mirrored");
  expect_middle(exact(mirrored), red, 4.99, "mirrored, exact");
}

TEST(Sides, AreOneSurfaceWhereTheyAreNotKnown) {
  Scene scene = sheet_scene();
  scene.objects[0].cloud.oriented.clear();
  const Eigen::Vector3f grey(0.5f, 0.0f, 0.5f);
  for (const Image& image : {sampled(scene, 1), exact(scene), reference(scene, 2)}) {
    const std::size_t middle = static_cast<std::size_t>(image.height / 2 * image.width + image.width / 2);
    EXPECT_NEAR(image.rgba[4 * middle], 0.5f, 0.01f);
    EXPECT_NEAR(image.rgba[4 * middle + 2], 0.5f, 0.01f);
  }
}

TEST(Sides, OfEquallyNearOnesTheFrontLeads) {
  for (const bool swapped : {false, true}) {
    Scene scene = test::stage();
    Object object;
    for (const bool front : {!swapped, swapped})
      test::add_disc(object, {0, 0, 0}, {0, 0, front ? 1.0 : -1.0}, 1.0, front ? red : blue);
    object.cloud.oriented = {1, 1};
    scene.objects = {object};
    expect_middle(sampled(scene, 1), red, 5.0, "sampled");
    expect_middle(exact(scene), red, 5.0, "exact");
    expect_middle(reference(scene, 2), red, 5.0, "reference");
    test::move(scene.objects[0], {-0.1, 0.0, 0.0}, {0.1, 0.0, 0.0});
    expect_middle(sampled(scene, 4), red, 5.0, "sampled, moving");
    expect_middle(exact(scene), red, 5.0, "exact, moving");
    expect_middle(reference(scene, 4), red, 5.0, "reference, moving");
  }
}

/// Discs of every direction, some of them transparent, some oriented, that turn over; a sheet among them
/// that turns edge-on. All that can go wrong with sides at once.
Scene tumbling_scene(unsigned seed) {
  Scene scene = test::stage();
  test::Random random(seed);
  Object cloud;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d at = random.vector(-1.0, 1.0);
    test::add_disc(cloud, at, random.vector(-1.0, 1.0).normalized(), random(0.1, 0.4),
                   random.vector(0.0, 1.0).cast<float>());
    cloud.cloud.oriented.push_back(i % 5 != 0);
    cloud.cloud.opacity.push_back(i % 3 == 0 ? static_cast<float>(random(0.2, 0.9)) : 1.0f);
  }
  test::move(cloud, {-0.3, 0.0, 0.0}, {0.3, 0.1, 0.2}, 1.5);
  Object turning = sheet(0.02);
  turning.cloud.opacity.assign(turning.cloud.size(), 0.7f);
  test::move(turning, {0.2, 0.0, 0.4}, {0.0, 0.0, 0.4}, 2.0);
  Object folded = sheet(0.05, 8, 0.25);
  folded.two_sided = false;
  test::move(folded, {-0.5, -0.6, 0.0}, {-0.2, -0.5, 0.0}, 0.7);
  scene.objects = {cloud, turning, folded};
  return scene;
}

TEST(Sides, SampledIsTheReferenceAtItsInstants) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    Scene scene = tumbling_scene(seed);
    EXPECT_GE(decibels(sampled(scene, 16), reference(scene, 16)), 80.0) << seed;
    scene.model.coverage = Coverage::hard;
    EXPECT_GE(decibels(sampled(scene, 16), reference(scene, 16)), 60.0) << seed;
    scene.model.depth_tolerance = 0.0;
    EXPECT_GE(decibels(sampled(scene, 16), reference(scene, 16)), 60.0) << seed;
  }
}

TEST(Sides, ExactIsTheReference) {
  for (const unsigned seed : {1u, 2u}) {
    Scene scene = tumbling_scene(seed);
    scene.model.segments = 4;
    EXPECT_GE(decibels(exact(scene), reference(scene, 1024, ReferenceMotion::segments)), 70.0) << seed;
  }
}

TEST(Sides, ChangeNoBitWithTheInstructionSetOrTheOrderOfPoints) {
  const Scene scene = tumbling_scene(4);
  const Image image = sampled(scene, 6);
  for (int i = 0; i < static_cast<int>(sampled_maths().count); ++i) {
    const Image other = sampled(scene, 6, i);
    EXPECT_EQ(image.rgba, other.rgba) << i;
    EXPECT_EQ(image.depth, other.depth) << i;
  }
  Scene turned = scene;
  for (Object& object : turned.objects) test::reverse_points(object.cloud);
  EXPECT_EQ(image.rgba, sampled(turned, 6).rgba);
  Scene few = scene, few_turned = turned;
  few.model.segments = few_turned.model.segments = 2;
  AbufferOptions plain;
  plain.simd = false;
  const Image swept = exact(few);
  EXPECT_EQ(swept.rgba, exact(few, plain).rgba);
  EXPECT_EQ(swept.rgba, exact(few_turned).rgba);
}

TEST(Sides, StillIsWhatTheExactMethodMakesOfIt) {
  Scene scene = tumbling_scene(5);
  for (Object& object : scene.objects) object.transform = {};
  EXPECT_EQ(sampled(scene, 1).rgba, exact(scene).rgba);
  EXPECT_GE(decibels(exact(scene), reference(scene, 2)), 80.0);
}

TEST(Sides, LayersAreOfTheSideThatIsSeen) {
  Scene scene = sheet_scene();
  // Were the back's normals among them, they would be turned toward the eye and change nothing; so those
  // lean.
  SurfelPose& pose = scene.objects[0].cloud.keys[0].pose;
  for (std::size_t i = 1; i < pose.size(); i += 2) {
    const Eigen::Vector3d normal = Eigen::Vector3d(0.05, 0.0, -1.0).normalized(), u = normal.unitOrthogonal();
    pose.axis_u[i] = (0.16 * u).cast<float>();
    pose.axis_v[i] = (0.16 * normal.cross(u)).cast<float>();
  }
  const auto layers = render_layers(scene, {.normal = true});
  ASSERT_TRUE(layers.ok());
  const std::size_t middle = 24 * 64 + 32;
  EXPECT_NEAR((*layers)[0].values[middle], 0.0f, 1e-6f);
  EXPECT_NEAR((*layers)[2].values[middle], 1.0f, 1e-6f);
}

/// A pixel's fragments that never end, and what the reference makes of them at an instant.
struct Planted {
  FragmentArrays fragments;
  std::vector<Shade> shades;

  void add(float y, float rate, float peak, float z, float z_rate, const Shade& shade) {
    fragments.ensure(1);
    const std::size_t i = fragments.count++;
    fragments.pixel[i] = 0;
    fragments.kernel[i] = static_cast<std::uint32_t>(shades.size());
    fragments.t_begin[i] = 0;
    fragments.t_end[i] = shutter_close;
    fragments.y[i] = y, fragments.rate[i] = rate, fragments.peak[i] = peak;
    fragments.z[i] = z, fragments.z_rate[i] = z_rate;
    shades.push_back(shade);
  }

  [[nodiscard]] Eigen::Vector4d at(double tau, const ImageModel& model) const {
    std::vector<reference::Disc> discs(fragments.count);
    std::vector<reference::Fragment> met;
    for (std::size_t i = 0; i < fragments.count; ++i) {
      discs[i].tolerance = shades[i].depth_tolerance;
      discs[i].color = Eigen::Vector4f(shades[i].rgba).cast<double>();
      const double y = fragments.y[i] + fragments.rate[i] * tau;
      const int side = shades[i].side == Side::front ? 1 : shades[i].side == Side::back ? -1 : 0;
      met.push_back({fragments.z[i] + fragments.z_rate[i] * tau, fragments.peak[i] * std::exp(-y * y),
                     &discs[i], side});
    }
    reference::PixelSum sum;
    reference::shade(met, model, Eigen::Vector4d::Zero(), sum);
    return sum.color;
  }
};

TEST(Sides, SweptAreTheMeanOfTheirInstants) {
  test::Random random(11);
  for (int round = 0; round < 2000; ++round) {
    Planted planted;
    ImageModel model;
    model.coverage = round % 4 == 0 ? Coverage::hard : Coverage::soft;
    const bool still = round % 6 == 0;
    const int count = 2 + round % 9;
    for (int i = 0; i < count; ++i) {
      const float alpha = i % 2 == 0 ? 1.0f : static_cast<float>(random(0.3, 0.9));
      const Eigen::Vector3f color = alpha * random.vector(0.0, 1.0).cast<float>();
      const auto side = static_cast<Side>(static_cast<int>(random(0.0, 2.999)));
      planted.add(still ? 0.0f : static_cast<float>(random(-0.6, 0.3)),
                  still ? 0.0f : static_cast<float>(random(0.0, 0.6)), static_cast<float>(random(0.05, 1.0)),
                  static_cast<float>(random(1.0, 1.4)), still ? 0.0f : static_cast<float>(random(-0.3, 0.3)),
                  {{color[0], color[1], color[2], alpha}, static_cast<float>(random(0.0, 0.3)), side});
    }
    std::vector<std::uint32_t> indices(planted.fragments.count);
    std::iota(indices.begin(), indices.end(), 0u);
    PixelSum pixel;
    SweepCounters counters;
    PixelSweep(SurfaceModel(model))
        .resolve(planted.fragments, planted.shades, indices.data(), indices.size(), pixel, counters);
    Eigen::Vector4d mean = Eigen::Vector4d::Zero();
    constexpr int instants = 2000;
    for (int k = 0; k < instants; ++k) mean += planted.at((k + 0.5) / instants, model) / instants;
    // A change of surfaces falls between two instants: at most a few dozen of them, half a step each. The
    // sweep's own pieces are off by 2⁻¹² of the shutter at most.
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(pixel.rgba[c], mean[c], 1e-3) << round << ' ' << c;
    if (!still) continue;
    PixelSum alone;
    StillPixel(SurfaceModel(model))
        .resolve(planted.fragments, planted.shades, indices.data(), indices.size(), alone);
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(alone.rgba[c], mean[c], 1e-5) << round << ' ' << c;
  }
}

}  // namespace
}  // namespace swept
