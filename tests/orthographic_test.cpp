// The orthographic camera: closed forms, the far end of pinholes, and the same picture from every method.
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/layers.h"
#include "abuffer/reference/reference.h"
#include "abuffer/sampled.h"
#include "abuffer/simd/sampled_math.h"
#include "abuffer/stochastic/stochastic.h"
#include "tests/drawn.h"
#include "tests/image_difference.h"
#include "tests/small_scenes.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using test::decibels, test::reference, test::sampled;

Image sampled_to(const Scene& scene, double db) {
  SampledOptions options;
  options.max_error_db = db;
  return test::value_of(render_sampled(scene, options)).image;
}
Image exact(const Scene& scene) { return test::exact(scene).image; }
Image stochastic(const Scene& scene, int samples, Traversal traversal = Traversal::tile) {
  StochasticOptions options;
  options.samples = samples;
  options.traversal = traversal;
  return test::value_of(render_stochastic(scene, options)).image;
}

/// Relative, by alpha, root mean square.
double depth_error(const Image& image, const Image& truth) { return test::difference_of(image, truth).depth; }

/// 4 world units along the height: 12 px each.
Scene parallel(Scene scene) {
  scene.camera.orthographic = true;
  for (LookAtKey& key : scene.camera.look_ats) key.tan_half_fov_y = 2.0;
  return scene;
}

/// Spheres that pass through each other and turn, seen by a camera that moves, turns, leans and zooms.
Scene stress() {
  Scene scene = parallel(test::busy_scene());
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  LookAtKey& open = scene.camera.look_ats.front();
  open.lens.stretch_x = 1.2;
  open.lens.shift = {0.05, -0.1};
  LookAtKey close = open;
  close.frame = 1.0;
  close.eye = {0.7, 0.3, 4.0};
  close.target = {0.1, 0.2, 0.0};
  close.roll_radians = 0.2;
  close.tan_half_fov_y = 1.6;
  close.lens.shift = {-0.05, 0.0};
  scene.camera.look_ats.push_back(close);
  return scene;
}

TEST(Orthographic, StillsOfAllMethodsAreOne) {
  Scene scene = stress();
  scene.shutter = {0.3, 0.3};
  const Image truth = reference(scene, 2), image = sampled(scene, 1);
  EXPECT_GE(decibels(image, truth), 95.0);
  EXPECT_GE(decibels(exact(scene), truth), 110.0);
  EXPECT_LE(depth_error(image, truth), 1e-5);
  EXPECT_LE(depth_error(exact(scene), truth), 1e-6);
  // Everything is seen from one side alone where it may only be.
  for (Object& object : scene.objects) object.two_sided = false;
  const Image one_sided = reference(scene, 2);
  EXPECT_GE(decibels(sampled(scene, 1), one_sided), 95.0);
  EXPECT_GE(decibels(exact(scene), one_sided), 110.0);
  for (Object& object : scene.objects) object.cloud.oriented.assign(object.cloud.size(), true);
  EXPECT_GE(decibels(sampled(scene, 1), reference(scene, 2)), 95.0);
}

TEST(Orthographic, MovingDiscsAreThoseOfTheReference) {
  Scene scene = stress();
  const Image truth = reference(scene, 768);
  EXPECT_GE(decibels(sampled(scene, 512), truth), 70.0);
  EXPECT_GE(decibels(sampled_to(scene, 70.0), truth), 70.0);
  // Straight segments of both, so that only what is done with them is compared.
  EXPECT_GE(decibels(exact(scene), reference(scene, 1024, ReferenceMotion::segments)), 70.0);
  // And against the curved path, as it is cut unasked and in short chords.
  scene.model.segments = 0;
  const double unasked = decibels(exact(scene), truth);
  std::printf("a keyed zoom, unasked: %.1f dB\n", unasked);
  EXPECT_GE(unasked, 70.0);
  scene.model.segments = 64;
  EXPECT_GE(decibels(exact(scene), truth), 70.0);
  scene.camera.look_ats[1].tan_half_fov_y = scene.camera.look_ats[0].tan_half_fov_y;
  EXPECT_GE(decibels(exact(scene), reference(scene, 768)), 70.0);
}

TEST(Orthographic, EveryImplementationHasTheSameBits) {
  const Scene scene = stress();
  const Image first = sampled(scene, 5, 0);
  for (std::size_t i = 1; i < sampled_maths().count; ++i)
    EXPECT_EQ(sampled(scene, 5, static_cast<int>(i)).rgba, first.rgba) << i;
  Scene crop = scene;
  crop.film.crop_x = 11, crop.film.crop_y = 7, crop.film.crop_width = 30, crop.film.crop_height = 20;
  const Image window = sampled(crop, 5);
  EXPECT_TRUE(test::is_crop_of(window, first, crop.film));
}

TEST(Orthographic, ADiscParallelToTheFilmIsTheSameAtAnyDepth) {
  const auto at_depth = [](double depth, double radius) {
    Scene scene = parallel(test::stage());
    Object object;
    test::add_disc(object, {0.3, -0.2, 5.0 - depth}, {0, 0, 1}, radius, {0.9f, 0.4f, 0.2f});
    scene.objects = {object};
    return scene;
  };
  const Image near = sampled(at_depth(0.5, 0.8), 1);
  for (const double depth : {2.0, 64.0, 1e6}) {
    for (const Image& image : {sampled(at_depth(depth, 0.8), 1), exact(at_depth(depth, 0.8)),
                               reference(at_depth(depth, 0.8), 2), stochastic(at_depth(depth, 0.8), 1)}) {
      EXPECT_GE(decibels(image, near), 100.0) << depth;
      EXPECT_NEAR(image.depth[24 * 64 + 32], depth, 1e-6 * depth);
    }
  }
  // Where it is: the middle of its light, 12 px for each unit, x to the right and y up.
  double total = 0.0, x = 0.0, y = 0.0;
  for (int j = 0; j < 48; ++j)
    for (int i = 0; i < 64; ++i) {
      const double alpha = near.rgba[4 * static_cast<std::size_t>(j * 64 + i) + 3];
      total += alpha, x += alpha * (i + 0.5), y += alpha * (j + 0.5);
    }
  EXPECT_NEAR(x / total, 32.0 + 12.0 * 0.3, 0.02);
  EXPECT_NEAR(y / total, 24.0 + 12.0 * 0.2, 0.02);
  // A sparse disc without a filter has the area of an ellipse, foreshortened by its tilt and by nothing else.
  Scene tilted = at_depth(3.0, 0.0);
  tilted.model.coverage = Coverage::hard;
  tilted.model.filter_radius_px = 0.0;
  tilted.film = {640, 480, 0, 0, 0, 0};
  tilted.objects = {Object{}};
  test::add_disc(tilted.objects[0], {0.3, -0.2, 2.0}, Eigen::Vector3d(0.6, 0.0, 0.8), 1.0);
  for (const Image& image : {sampled(tilted, 1), exact(tilted), reference(tilted, 2)}) {
    double area = 0.0;
    for (std::size_t p = 0; p < image.pixel_count(); ++p) area += image.rgba[4 * p + 3];
    EXPECT_NEAR(area, M_PI * 0.8 * 120.0 * 120.0, 1e-3 * area);
  }
}

TEST(Orthographic, IsThePinholeFarAway) {
  Scene scene = test::busy_scene();
  constexpr double away = 1e5;
  Scene far = scene;
  far.camera.look_ats.front().eye = {0, 0, away};
  far.camera.look_ats.front().tan_half_fov_y = 2.0 / away;
  // Floats have seven digits: those of depth are gone, and with them what is in front of what.
  scene.objects.resize(1), far.objects.resize(1);
  for (Scene* both : {&scene, &far}) {
    both->shutter = {0.2, 0.2};
    both->objects.front().two_sided = false;
    both->model.depth_tolerance = 100.0;
  }
  EXPECT_GE(decibels(reference(parallel(scene), 2), reference(far, 2)), 70.0);
  EXPECT_GE(decibels(exact(parallel(scene)), reference(far, 2)), 70.0);
  EXPECT_GE(decibels(sampled(parallel(scene), 1), reference(far, 2)), 70.0);
}

TEST(Orthographic, WhatComesThroughTheNearPlaneIsCut) {
  Scene scene = parallel(test::stage());
  scene.camera.near = 1.0;
  test::Random random(4);
  for (int n = 0; n < 3; ++n) {
    Object object = test::checkered_sphere(0.8, 300);
    const double x = random(-1.5, 1.5), z = random(3.0, 5.0);
    test::move(object, {x, 0.1, z}, {x + 0.5, -0.2, z + 0.8}, 0.5);
    scene.objects.push_back(std::move(object));
  }
  scene.model.segments = 8;
  EXPECT_GE(decibels(sampled(scene, 1024), reference(scene, 1024)), 60.0);
  EXPECT_GE(decibels(exact(scene), reference(scene, 1024, ReferenceMotion::segments)), 60.0);
}

/// Two meshes that turn and pass through each other, one of them transparent.
Scene of_triangles(bool both = true) {
  Scene scene = stress();
  scene.objects.clear();
  test::Random random(7);
  for (int n = 0; n < (both ? 2 : 1); ++n) {
    Object object =
        test::triangles_about(16, n == 0 ? 1.0f : 0.6f, random, [&] { return random.vector(-1.2, 1.2); });
    test::move(object, {0.4 * n, 0, 0}, {-0.3, 0.2 * n, 0.3}, 0.7);
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

TEST(Orthographic, TrianglesAreThoseOfTheReference) {
  Scene scene = of_triangles();
  Scene still = scene;
  still.shutter = {0.4, 0.4};
  EXPECT_GE(decibels(sampled(still, 1), reference(still, 2)), 70.0);
  const Image truth = reference(scene, 1024), swept = exact(scene);
  EXPECT_GE(decibels(swept, truth), 70.0);
  EXPECT_GE(decibels(sampled_to(scene, 72.0), truth), 70.0);
  EXPECT_LE(depth_error(swept, truth), 1e-3);
  EXPECT_LE(depth_error(sampled(still, 1), reference(still, 2)), 1e-3);
  // From one side, and cut by the near plane.
  for (Object& object : scene.objects) object.two_sided = false;
  scene.camera.near = 4.4;
  EXPECT_GE(decibels(exact(scene), reference(scene, 512)), 65.0);
  still.camera.near = 4.4;
  EXPECT_GE(decibels(sampled(still, 1), reference(still, 2)), 60.0);
}

TEST(Orthographic, RandomSamplesConvergeToTheSame) {
  // Discs alone, and one mesh alone, where the models agree but for a pixel's places.
  Scene discs = stress();
  discs.model.segments = 32;
  const Image truth = reference(discs, 256);
  const double few = test::difference_of(stochastic(discs, 16), truth).color,
               many = test::difference_of(stochastic(discs, 512), truth).color;
  EXPECT_LE(many, few / 4.0) << "chance alone makes 32 times the samples 5.7 times as good";
  EXPECT_LE(many, 0.004);
  EXPECT_EQ(stochastic(discs, 16, Traversal::interval).rgba, stochastic(discs, 16).rgba);
  const Scene mesh = of_triangles(false);
  const Image tiles = stochastic(mesh, 16);
  EXPECT_EQ(stochastic(mesh, 16, Traversal::interval).rgba, tiles.rgba);
  EXPECT_GE(decibels(stochastic(mesh, 1024), reference(mesh, 128)), 35.0);
  StochasticOptions boxes;
  boxes.traversal = Traversal::hierarchy;
  const auto refused = render_stochastic(mesh, boxes);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "traversal");
}

Scene of_splats(bool flat) {
  Scene scene = test::random_splats(150, 3);
  scene.film = {75, 50, 0, 0, 0, 0};
  scene.camera.orthographic = true;
  LookAtKey close = scene.camera.look_ats.front();
  close.frame = 1.0;
  close.eye = {0.4, 0.1, 0.5};
  close.tan_half_fov_y = 2.6;
  scene.camera.look_ats.front().tan_half_fov_y = 3.0;
  close.lens.stretch_x = scene.camera.look_ats.front().lens.stretch_x = 1.1;
  scene.camera.look_ats.push_back(close);
  SplatCloud& cloud = scene.objects.front().splats;
  cloud.flat = flat;
  if (flat)
    for (Eigen::Vector3f& scale : cloud.scale) scale.z() = 0.0f;
  return scene;
}

TEST(Orthographic, SplatsAreThoseOfTheReference) {
  for (const bool flat : {false, true}) {
    Scene scene = of_splats(flat);
    scene.shutter = {0.5, 0.5};
    EXPECT_GE(test::psnr_db(sampled(scene, 1), reference(scene, 2)), 90.0) << flat;
    scene.shutter = {0.0, 1.0};
    EXPECT_GE(test::psnr_db(sampled_to(scene, 72.0), reference(scene, 128)), 70.0) << flat;
    // Among surfaces.
    Object ball = test::checkered_sphere(1.0, 300);
    test::move(ball, {0, 0, 6}, {0.5, 0.1, 7}, 0.4);
    scene.objects.push_back(ball);
    scene.shutter = {0.5, 0.5};
    EXPECT_GE(test::psnr_db(sampled(scene, 1), reference(scene, 2)), 80.0) << flat;
  }
  // A round splat has the same picture at any depth.
  Scene one = test::one_splat({0.1, 0.2, 2.0}, 0.2f, 0.8f, 0.7f);
  one.camera.orthographic = true;
  one.camera.look_ats.front().tan_half_fov_y = 1.0;
  const Image near = sampled(one, 1);
  one.objects.front().splats.position = {{0.1, 0.2, 2000.0}};
  EXPECT_GE(test::psnr_db(sampled(one, 1), near), 100.0);
}

TEST(Orthographic, LayersFollowParallelRays) {
  Scene scene = parallel(test::stage());
  Object object;
  for (const double z : {0.0, -20.0}) test::add_disc(object, {z == 0.0 ? -1.0 : 1.0, 0.0, z}, {0, 0, 1}, 0.6);
  test::move(object, {0, 0, 0}, {0.5, 0.25, -1.0});
  scene.objects = {object};
  LayerChoice choice;
  choice.motion = choice.normal = true;
  const auto layers = render_layers(scene, choice);
  ASSERT_TRUE(layers.ok());
  // 12 px a unit at any depth, v up; in the middle of the exposure both discs are 0.25 to the right.
  for (const int x : {32 - 12 + 3, 32 + 12 + 3}) {
    const std::size_t pixel = 22 * 64 + static_cast<std::size_t>(x);
    const auto value = [&](const char* name) {
      for (const ImageChannel& channel : *layers)
        if (channel.name == name) return channel.values[pixel];
      return NAN;
    };
    EXPECT_NEAR(value("forward.u"), 6.0, 1e-3);
    EXPECT_NEAR(value("forward.v"), 3.0, 1e-3);
    EXPECT_NEAR(value("backward.u"), -6.0, 1e-3);
    EXPECT_NEAR(value("normal.z"), 1.0, 1e-6);
  }
}

TEST(Orthographic, WhatCannotBeIsRefused) {
  Scene scene = stress();
  scene.camera.aperture.radius = 0.1;
  for (LookAtKey& key : scene.camera.look_ats) key.lens.focus = 4.0;
  const Status lens = scene.validate();
  ASSERT_FALSE(lens.ok());
  EXPECT_EQ(lens.error().field, "/camera/lens");
  EXPECT_EQ(lens.error().kind, ErrorKind::unsupported);
  scene.camera.aperture = {};
  scene.camera.look_ats[1].tan_half_fov_y = 0.0;
  const Status height = scene.validate();
  ASSERT_FALSE(height.ok());
  EXPECT_EQ(height.error().field, "/camera/keys/1/height");
}

}  // namespace
}  // namespace swept
