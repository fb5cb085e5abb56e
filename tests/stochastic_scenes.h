// Scenes for tests of the sampled method, and what its images are compared with.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "abuffer/stochastic/stochastic.h"
#include "tests/drawn.h"
#include "tests/small_scenes.h"

namespace swept::test {

inline Rendered rendered(const Scene& scene, const StochasticOptions& options, int threads = 0) {
  RenderControl control;
  control.threads = threads;
  return value_of(render_stochastic(scene, options, control));
}

inline double mean_difference(const Image& a, const Image& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) sum += double{a.rgba[i]} - double{b.rgba[i]};
  return sum / static_cast<double>(a.rgba.size());
}

/// Triangles of all sizes, some of them through the near plane and behind the eye, which is at z = 5.
inline Object soup(int triangles, unsigned seed, bool transparent) {
  Random random(seed);
  Object object;
  for (int t = 0; t < triangles; ++t) {
    const Eigen::Vector3d middle(random(-2.0, 2.0), random(-1.5, 1.5), random(-2.0, 4.8));
    const double size = std::pow(10.0, random(-2.0, 0.2));
    for (int i = 0; i < 3; ++i) {
      add_disc(object, middle + random.vector(-size, size), {0, 0, 1}, 0.1,
               random.vector(0.0, 1.0).cast<float>());
      object.cloud.velocity.push_back(random.vector(-0.5, 0.5).cast<float>());
      if (transparent) object.cloud.opacity.push_back(static_cast<float>(random(0.0, 1.0)));
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    object.triangles.push_back({first, first + 1, first + 2});
  }
  return object;
}

/// A turning soup: corners on curves.
inline Scene soup_scene(unsigned seed, bool transparent) {
  Scene scene = stage();
  scene.background = {0.1f, 0.2f, 0.3f, 1.0f};
  scene.objects = {soup(60, seed, transparent)};
  move(scene.objects[0], {0.1, 0, 0}, {-0.2, 0.1, 0.2}, 0.9);
  return scene;
}

inline void add_lens(Scene& scene) {
  scene.camera.aperture.radius = 0.15;
  scene.camera.look_ats[0].lens.focus = 4.0;
}

inline std::vector<StochasticOptions> all_traversals(int samples, int times) {
  std::vector<StochasticOptions> all;
  for (const CurveBounds bounds : {CurveBounds::slefes, CurveBounds::hulls})
    for (const int px : {1, 2, 4, 16})
      all.push_back({.samples = samples,
                     .times = times,
                     .traversal = Traversal::tile,
                     .tile_px = px,
                     .bounds = bounds});
  for (const int intervals : {1, 4, 7, 64})
    all.push_back(
        {.samples = samples, .times = times, .traversal = Traversal::interval, .intervals = intervals});
  if (hierarchy_available())
    for (const int px : {1, 4})
      all.push_back({.samples = samples, .times = times, .traversal = Traversal::hierarchy, .tile_px = px});
  if (times > 0) all.push_back({.samples = samples, .times = times, .traversal = Traversal::interleave});
  all.push_back({.samples = samples, .times = times});
  return all;
}

inline void expect_same_images(const Scene& scene, int samples, int times, const char* what) {
  const std::vector<StochasticOptions> all = all_traversals(samples, times);
  const Rendered first = rendered(scene, all.front());
  EXPECT_GT(*first.statistics.counter("samples_inside"), 0.0) << what;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Rendered other = rendered(scene, all[i]);
    EXPECT_EQ(other.image.rgba, first.image.rgba) << what << ", traversal " << i;
    EXPECT_EQ(other.image.depth, first.image.depth) << what << ", traversal " << i;
    EXPECT_EQ(other.statistics.counter("samples_inside"), first.statistics.counter("samples_inside"))
        << what << i;
  }
}

}  // namespace swept::test
