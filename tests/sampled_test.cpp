// The sampled engine against the reference, which shares no rasteriser with it, and against itself.
#include "abuffer/sampled.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <stop_token>

#include <gtest/gtest.h>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "abuffer/resolve/sample_plan.h"
#include "abuffer/simd/sampled_math.h"
#include "datasets/generators.h"
#include "splat/compare/metrics.h"
#include "tests/counter.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"

namespace swept {
namespace {

using test::counter;

/// A ball that turns and crosses a third of the film while the shutter is open.
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

SampledOptions instants(int count) {
  SampledOptions options;
  options.samples = count;
  return options;
}

RenderControl threads(int count) {
  RenderControl control;
  control.threads = count;
  return control;
}

double largest_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    largest = std::max(largest, std::abs(static_cast<double>(a.rgba[i]) - static_cast<double>(b.rgba[i])));
  return largest;
}

double psnr(const Image& a, const Image& b) {
  const auto metrics = compare_images(a, b);
  EXPECT_TRUE(metrics.ok());
  return metrics->psnr_db;
}

void expect_same_bits(const Image& a, const Image& b) {
  EXPECT_EQ(a.rgba, b.rgba);
  EXPECT_EQ(a.depth, b.depth);
}

/// Beside the reference at the same instants: rounding only, and here and there a fragment at the very end of
/// a surface's reach.
void expect_reference(const Scene& scene, int count, double least_db) {
  const auto sampled = render_sampled(scene, instants(count));
  ReferenceOptions options;
  options.samples = count;
  options.motion = ReferenceMotion::smooth;
  const auto reference = render_reference(scene, options);
  ASSERT_TRUE(sampled.ok() && reference.ok());
  EXPECT_GE(psnr(sampled->image, reference->image), least_db);
  double depth = 0.0;
  for (std::size_t i = 0; i < sampled->image.depth.size(); ++i) {
    const double a = double{sampled->image.depth[i]}, b = double{reference->image.depth[i]};
    // What is hardly there has hardly a depth.
    if (double{reference->image.rgba[4 * i + 3]} < 1e-3) continue;
    EXPECT_EQ(std::isfinite(a), std::isfinite(b));
    if (std::isfinite(a) && std::isfinite(b)) depth = std::max(depth, std::abs(a - b));
  }
  EXPECT_LT(depth, 2e-3);
}

TEST(Sampled, IsTheReferenceAtTheSameInstants) {
  const Scene scene = turning_ball();
  expect_reference(scene, 8, 110.0);
  // The picture is not empty, and differs from its neighbours.
  const auto eight = render_sampled(scene, instants(8)), sixteen = render_sampled(scene, instants(16));
  ASSERT_TRUE(eight.ok() && sixteen.ok());
  EXPECT_GT(largest_difference(eight->image, sixteen->image), 0.01);
}

TEST(Sampled, IsTheReferenceWithHardCoverage) {
  Scene scene = turning_ball();
  scene.model.coverage = Coverage::hard;
  expect_reference(scene, 6, 100.0);
}

TEST(Sampled, IsTheReferenceWhereLightGetsThrough) {
  Scene scene = test::busy_scene();
  for (Object& object : scene.objects) {
    object.cloud.opacity.resize(object.cloud.size());
    for (std::size_t i = 0; i < object.cloud.size(); ++i)
      object.cloud.opacity[i] = 0.02f + 0.3f * static_cast<float>(i % 4);
  }
  scene.background = {0.3f, 0.1f, 0.6f, 0.5f};
  expect_reference(scene, 4, 100.0);
}

TEST(Sampled, IsTheReferenceOneSided) {
  Scene scene = test::busy_scene();
  for (Object& object : scene.objects) object.two_sided = false;
  // Mirrored, an outside stays an outside.
  for (TransformKey& key : scene.objects[0].transform.keys) key.scale = {-1.0, 1.0, 1.0};
  expect_reference(scene, 4, 100.0);
}

TEST(Sampled, IsTheReferenceWithoutAFilter) {
  Scene scene = turning_ball();
  scene.model.filter_radius_px = 0.0;
  expect_reference(scene, 4, 90.0);
}

TEST(Sampled, IsTheReferenceThroughTheNearPlaneAndTheEye) {
  Scene scene = test::stage();
  scene.objects = {test::checkered_sphere(1.5, 400)};
  test::move(scene.objects[0], {0.0, 0.0, 2.0}, {0.3, 0.1, 6.5}, 0.7);
  expect_reference(scene, 16, 90.0);
}

TEST(Sampled, IsTheReferenceForParticlesSmallerThanAPixel) {
  Scene scene = test::stage();
  Object& object = scene.objects.emplace_back();
  test::Random random(7);
  for (int i = 0; i < 3000; ++i) {
    test::add_disc(object, random.vector(-1.5, 1.5), random.vector(-1.0, 1.0).normalized(), 0.004,
                   random.vector(0.0, 1.0).cast<float>());
    object.cloud.velocity.push_back(random.vector(-0.3, 0.3).cast<float>());
  }
  object.cloud.keys[0].frame = 0.5;
  expect_reference(scene, 8, 100.0);
}

TEST(Sampled, IsTheReferenceOfKeyedPointsAtSurveyCoordinates) {
  Scene scene = test::stage();
  Object object = test::checkered_sphere(0.8, 700);
  SurfelKey later = object.cloud.keys[0], last = object.cloud.keys[0];
  later.frame = 0.4, last.frame = 1.0;
  for (Eigen::Vector3d& p : later.pose.position) p += Eigen::Vector3d(0.4, 0.3, 0.0);
  for (Eigen::Vector3d& p : last.pose.position) p += Eigen::Vector3d(0.8, -0.2, 0.5);
  for (Eigen::Vector3f& a : last.pose.axis_u) a *= 1.5f;
  object.cloud.keys = {object.cloud.keys[0], later, last};
  const Eigen::Vector3d far(5e6, -3e6, 2e5);
  for (SurfelKey& key : object.cloud.keys)
    for (Eigen::Vector3d& p : key.pose.position) p += far;
  scene.objects = {object};
  scene.camera.look_ats[0].eye += far;
  scene.camera.look_ats[0].target += far;
  expect_reference(scene, 8, 100.0);
}

TEST(Sampled, ConvergesToTheExactImage) {
  Scene scene = turning_ball();
  scene.model.segments = 64;
  const auto exact = render_abuffer(scene);
  ASSERT_TRUE(exact.ok());
  double before = 1.0;
  for (const int samples : {4, 16, 64}) {
    const auto stills = render_sampled(scene, instants(samples));
    ASSERT_TRUE(stills.ok());
    const double error = largest_difference(stills->image, exact->image);
    // Where a pixel's signal jumps the midpoint rule errs by up to a sample, so four times as many halve it
    // by far.
    EXPECT_LT(error, 0.5 * before) << samples;
    before = error;
  }
}

TEST(Sampled, TheSameBitsForAnyNumberOfThreads) {
  const Scene scene = test::busy_scene();
  for (const SampledOptions& options : {instants(4), SampledOptions{}}) {
    const auto one = render_sampled(scene, options, threads(1)),
               three = render_sampled(scene, options, threads(3));
    ASSERT_TRUE(one.ok() && three.ok());
    expect_same_bits(one->image, three->image);
  }
}

TEST(Sampled, TheSameBitsForEveryInstructionSet) {
  Scene scene = test::busy_scene();
  scene.objects[1].two_sided = false;
  scene.objects[2].cloud.opacity.assign(scene.objects[2].cloud.size(), 0.4f);
  const auto widest = render_sampled(scene, instants(5));
  ASSERT_TRUE(widest.ok());
  for (int i = 0; i < static_cast<int>(sampled_maths().count); ++i) {
    SampledOptions options = instants(5);
    options.implementation = i;
    const auto other = render_sampled(scene, options);
    ASSERT_TRUE(other.ok());
    expect_same_bits(widest->image, other->image);
  }
}

TEST(Sampled, TheSameBitsForAnyOrderOfPointsAndObjects) {
  const Scene scene = test::busy_scene();
  Scene shuffled = scene;
  std::mt19937 random(3);
  for (Object& object : shuffled.objects) {
    SurfelCloud& cloud = object.cloud;
    for (std::size_t left = cloud.size(); left > 1; --left) {
      const std::size_t i = left - 1, j = random() % left;
      for (SurfelKey& key : cloud.keys) {
        std::swap(key.pose.position[i], key.pose.position[j]);
        std::swap(key.pose.axis_u[i], key.pose.axis_u[j]);
        std::swap(key.pose.axis_v[i], key.pose.axis_v[j]);
      }
      std::swap(cloud.color[i], cloud.color[j]);
    }
  }
  std::rotate(shuffled.objects.begin(), shuffled.objects.begin() + 1, shuffled.objects.end());
  const auto a = render_sampled(scene, instants(3)), b = render_sampled(shuffled, instants(3));
  ASSERT_TRUE(a.ok() && b.ok());
  expect_same_bits(a->image, b->image);
}

TEST(Sampled, ACropIsThosePixelsOfTheWhole) {
  Scene scene = turning_ball();
  for (const SampledOptions& options : {instants(3), SampledOptions{}}) {
    scene.film = {200, 150, 0, 0, 0, 0};
    const auto whole = render_sampled(scene, options);
    scene.film.crop_x = 61, scene.film.crop_y = 37, scene.film.crop_width = 71, scene.film.crop_height = 90;
    const auto crop = render_sampled(scene, options);
    ASSERT_TRUE(whole.ok() && crop.ok());
    EXPECT_TRUE(test::is_crop_of(crop->image, whole->image, scene.film));
  }
}

TEST(Sampled, WhatDoesNotMoveTakesOneInstant) {
  Scene scene = turning_ball();
  scene.shutter = {0.25, 0.25};
  const auto closed = render_sampled(scene, instants(1000));
  ASSERT_TRUE(closed.ok());
  EXPECT_EQ(counter(*closed, "instants_per_pixel"), 1.0);
  // The same, standing still under an open shutter.
  scene.shutter = {-0.5, 0.5};
  const Eigen::Affine3d there = scene.objects[0].transform.at(0.25);
  scene.objects[0].transform.keys.resize(1);
  scene.objects[0].transform.keys[0].translate = there.translation();
  scene.objects[0].transform.keys[0].rotate_radians = 1.5;
  const auto still = render_sampled(scene, SampledOptions{});
  ASSERT_TRUE(still.ok());
  EXPECT_EQ(counter(*still, "instants_per_pixel"), 1.0);
  EXPECT_GE(psnr(closed->image, still->image), 120.0);
}

TEST(Sampled, CellsInWhichNothingMovesTakeOneInstant) {
  Scene scene = test::stage();
  scene.film = {256, 128, 0, 0, 0, 0};
  scene.objects = {test::checkered_sphere(0.4, 500), test::checkered_sphere(0.4, 500)};
  test::move(scene.objects[0], {-1.6, 0.0, 0.0}, {-1.4, 0.0, 0.0});
  test::move(scene.objects[1], {1.5, 0.0, 0.0}, {1.5, 0.0, 0.0});
  const auto rendered = render_sampled(scene, instants(12));
  ASSERT_TRUE(rendered.ok());
  EXPECT_EQ(counter(*rendered, "most_instants"), 12.0);
  EXPECT_LT(counter(*rendered, "instants_per_pixel"), 7.0);
}

TEST(Sampled, MeetsTheErrorThatIsAskedFor) {
  Scene scene = test::busy_scene();
  scene.film = {192, 144, 0, 0, 0, 0};
  const auto truth = render_sampled(scene, instants(1024));
  ASSERT_TRUE(truth.ok());
  for (const double asked : {40.0, 55.0, 70.0}) {
    SampledOptions options;
    options.max_error_db = asked;
    const auto rendered = render_sampled(scene, options);
    ASSERT_TRUE(rendered.ok());
    const double reached = psnr(rendered->image, truth->image),
                 expected = counter(*rendered, "expected_psnr_db");
    EXPECT_GE(reached, asked);
    // An estimate, and no bound; that it tells anything at all is that it is near.
    EXPECT_NEAR(reached, expected, 9.0) << asked;
  }
}

TEST(Sampled, MeetsTheErrorOfTheWorstCell) {
  Scene scene = test::busy_scene();
  scene.film = {192, 144, 0, 0, 0, 0};
  SampledOptions options;
  options.max_error_db = 30.0;
  const auto loose = render_sampled(scene, options);
  options.max_cell_error_db = 55.0;
  const auto strict = render_sampled(scene, options);
  ASSERT_TRUE(loose.ok() && strict.ok());
  EXPECT_GT(counter(*loose, "expected_worst_cell_rmse"), std::pow(10.0, -55.0 / 20.0));
  EXPECT_LE(counter(*strict, "expected_worst_cell_rmse"), std::pow(10.0, -55.0 / 20.0));
}

TEST(Sampled, IsAsGoodAsTheSecondsAllow) {
  const Scene scene = turning_ball();
  const auto truth = render_sampled(scene, instants(4096));
  ASSERT_TRUE(truth.ok());
  SampledOptions options;
  options.max_seconds = 1e-9;
  const auto at_once = render_sampled(scene, options);
  options.max_seconds = 2.0;
  const auto later = render_sampled(scene, options);
  ASSERT_TRUE(at_once.ok() && later.ok());
  // However little time there is, there is a picture; and what two seconds are for is known to be much more.
  EXPECT_GT(psnr(at_once->image, truth->image), 20.0);
  EXPECT_GT(psnr(later->image, truth->image), psnr(at_once->image, truth->image) + 10.0);
  EXPECT_NEAR(psnr(later->image, truth->image), counter(*later, "expected_psnr_db"), 9.0);
  EXPECT_GT(counter(*later, "most_instants"), counter(*at_once, "most_instants"));
}

TEST(Sampled, ShowsWhereTheErrorIsExpected) {
  const Scene scene = turning_ball();
  SampledOptions options;
  options.max_error_db = 50.0;
  const auto plain = render_sampled(scene, options);
  options.error_channel = true;
  const auto rendered = render_sampled(scene, options);
  const auto truth = render_sampled(scene, instants(4096));
  ASSERT_TRUE(plain.ok() && rendered.ok() && truth.ok());
  expect_same_bits(plain->image, rendered->image);
  EXPECT_TRUE(plain->image.channels.empty());
  ASSERT_EQ(rendered->image.channels.size(), 1u);
  const ImageChannel& error = rendered->image.channels.front();
  EXPECT_EQ(error.name, "error");
  ASSERT_EQ(error.values.size(), rendered->image.pixel_count());
  double squares = 0.0;
  for (const float e : error.values) squares += double{e} * double{e};
  const double rmse = std::sqrt(squares / static_cast<double>(error.values.size()));
  EXPECT_NEAR(rmse / counter(*rendered, "expected_rmse"), 1.0, 1e-3);
  // Half of the pixels, those where most is expected, have nearly all of the error.
  std::vector<float> sorted = error.values;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const float median = sorted[sorted.size() / 2];
  double there = 0.0, all = 0.0;
  for (std::size_t i = 0; i < error.values.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double off = double{rendered->image.rgba[4 * i + c]} - double{truth->image.rgba[4 * i + c]};
      all += off * off;
      if (error.values[i] > median) there += off * off;
    }
  EXPECT_GT(there, 0.9 * all);
}

TEST(Sampled, SaysWhatAFixedNumberOfInstantsIsOffBy) {
  const Scene scene = turning_ball();
  SampledOptions options = instants(16);
  const auto plain = render_sampled(scene, options);
  options.error_channel = true;
  const auto rendered = render_sampled(scene, options);
  const auto truth = render_sampled(scene, instants(4096));
  ASSERT_TRUE(plain.ok() && rendered.ok() && truth.ok());
  expect_same_bits(plain->image, rendered->image);
  EXPECT_NEAR(psnr(rendered->image, truth->image), counter(*rendered, "expected_psnr_db"), 9.0);
}

TEST(Sampled, TellsProgressAndStops) {
  const Scene scene = test::busy_scene();
  RenderControl control;
  double last = 0.0;
  std::atomic<int> told{0};
  control.progress = [&](double share) {
    EXPECT_GT(share, last);
    last = share;
    ++told;
  };
  ASSERT_TRUE(render_sampled(scene, instants(2), control).ok());
  EXPECT_EQ(last, 1.0);
  EXPECT_GT(told.load(), 0);
  std::stop_source source;
  source.request_stop();
  control.stop = source.get_token();
  const auto stopped = render_sampled(scene, instants(2), control);
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().reason, "the render was stopped");
}

TEST(Sampled, SaysWhatMemoryThePointsTake) {
  const Scene scene = turning_ball();
  const auto rendered = render_sampled(scene, instants(1));
  ASSERT_TRUE(rendered.ok());
  const double bytes = counter(*rendered, "packed_bytes");
  EXPECT_GT(bytes, 600 * 50.0);
  EXPECT_LT(bytes, 608 * 60.0);
  RenderControl control;
  control.max_bytes = static_cast<std::size_t>(bytes);
  EXPECT_TRUE(render_sampled(scene, instants(1), control).ok());
  control.max_bytes -= 1;
  EXPECT_EQ(render_sampled(scene, instants(1), control).error().field, "max_bytes");
}

TEST(Sampled, RefusesWhatIsOutOfRange) {
  const Scene scene = turning_ball();
  for (const int samples : {-1, 1 << 21}) {
    const auto refused = render_sampled(scene, instants(samples));
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "samples");
  }
  for (const double db : {0.0, -3.0, 151.0, std::nan("")}) {
    SampledOptions options;
    options.max_error_db = db;
    const auto refused = render_sampled(scene, options);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "max_error_db");
  }
  EXPECT_EQ(render_sampled(scene, instants(1), threads(-1)).error().field, "threads");
}

TEST(Sampled, ForeseesThatErrorsFallTheFasterTheCloserInstantsAreUntilJumpsLead) {
  // Few instants a pixel: what fell by a fifth falls by more.
  EXPECT_LT(expected_fall(0.2, 0.3), 0.2);
  EXPECT_GT(expected_fall(0.2, 0.3), 0.04);
  // What did not fall says little there, and nothing near an instant a pixel.
  EXPECT_GT(expected_fall(1.0, 0.1), 0.9);
  EXPECT_LT(expected_fall(1.0, 1.0), 0.2);
  for (const double before : {0.0, 0.01, 0.1, 0.25, 0.5, 1.0, 4.0})
    for (double x = 1.0 / 256.0; x < 256.0; x *= 1.25) {
      const double fall = expected_fall(before, x);
      EXPECT_GE(fall, 0.07) << before << " at " << x;
      EXPECT_LE(fall, 1.0) << before << " at " << x;
      EXPECT_GE(expected_fall(before + 0.1, x), fall) << before << " at " << x;
      // Jumps fall by 4, and little is more than a few dB better.
      if (x >= 4.0) {
        EXPECT_GE(fall, 0.25) << before << " at " << x;
      }
    }
}

TEST(Sampled, AllowsACellMoreErrorTheLongerItTakes) {
  // Half by area and half by time: four times as many pixels or instants are worth twice the error.
  const double share = error_share(1024.0, 100, 8);
  EXPECT_NEAR(error_share(4096.0, 100, 8), 2.0 * share, 1e-12 * share);
  EXPECT_NEAR(error_share(1024.0, 100, 32), 2.0 * share, 1e-12 * share);
  EXPECT_GT(error_share(1024.0, 400, 8), 1.8 * share);
  EXPECT_LT(error_share(1024.0, 400, 8), 2.0 * share);
  EXPECT_GT(error_share(1024.0, 0, 2), 0.0);
}

}  // namespace
}  // namespace swept
