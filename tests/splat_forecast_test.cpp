// How many instants splats take by what one still shows, on scenes that the rule was not fitted to.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/counter.h"
#include "tests/drawn.h"
#include "tests/splat_scenes.h"

namespace swept {
namespace {

using test::rendered;

/// Splats that stand still, and a camera that moves sideways by so many px of the film in their middle.
Scene passing(unsigned seed, float size, double px) {
  Scene scene = test::random_splats(1500, seed, size);
  scene.objects[0].splats.velocity.clear();
  LookAtKey to = scene.camera.look_ats[0];
  const double way = px * 7.0 * 2.0 * to.tan_half_fov_y / scene.film.height;
  to.frame = 1.0;
  to.eye.x() += way, to.target.x() += way;
  scene.camera.look_ats.push_back(to);
  return scene;
}

int cheapest(const Scene& scene, const Image& truth, double wanted_db) {
  int count = 1;
  while (count < 200 && test::psnr_db(rendered(scene, count).image, truth) < wanted_db) ++count;
  return count;
}

TEST(SplatForecast, TakesHardlyMoreThanTheCheapestNumber) {
  double ratios = 0.0, scenes = 0.0;
  for (const double px : {8.0, 25.0, 60.0})
    for (const float size : {0.03f, 0.1f}) {
      const Scene scene = passing(static_cast<unsigned>(300.0 + px), size, px);
      const Image truth = rendered(scene, 400).image;
      const Rendered chosen = rendered(scene, 0);
      EXPECT_GE(test::psnr_db(chosen.image, truth), 60.0) << px << ' ' << size;
      const double instants = test::counter(chosen, "instants_per_pixel");
      const int least = cheapest(scene, truth, 60.0);
      // The worst are fine splats that move a few pixels: a still has not the frequencies that matter there.
      EXPECT_LE(instants, 3.5 * least + 1.0) << px << ' ' << size << ", cheapest " << least;
      ratios += std::log(instants / least), scenes += 1.0;
    }
  EXPECT_LE(std::exp(ratios / scenes), 1.9);
}

TEST(SplatForecast, FastSplatsThatChangeTheirOrderAreForeseen) {
  // Large and opaque, each its own way: jumps are most of the error.
  for (const unsigned seed : {201u, 211u, 212u}) {
    const Scene scene = test::random_splats(500, seed, 0.2f);
    const Image truth = rendered(scene, 600).image;
    EXPECT_GE(test::psnr_db(rendered(scene, 0).image, truth), 60.0) << seed;
  }
}

TEST(SplatForecast, WhoPassesTheNearPlaneIsForeseen) {
  // Into the splats, past a bright one that covers the film until it is gone, sooner or later.
  for (const double ahead : {0.6, 0.71}) {
    Scene scene = test::random_splats(300, 330, 0.2f);
    scene.objects[0].splats.velocity.clear();
    LookAtKey to = scene.camera.look_ats[0];
    to.frame = 1.0;
    to.eye.z() += 1.0, to.target.z() += 1.0;
    scene.camera.look_ats.push_back(to);
    Object near = test::one_splat({0.02, 0.01, ahead}, 0.5f, 0.6f, 0.9f).objects[0];
    scene.objects.push_back(near);
    const Image truth = rendered(scene, 900).image;
    const Rendered chosen = rendered(scene, 0);
    EXPECT_GE(test::psnr_db(chosen.image, truth), 60.0)
        << ahead << ", " << test::counter(chosen, "instants_per_pixel") << ", expected "
        << test::counter(chosen, "expected_psnr_db");
  }
}

TEST(SplatForecast, TheStillIsOneOfTheInstants) {
  // What is foreseen to be enough and is: as many instants as N stills have, and their mean.
  const Scene scene = passing(320, 0.4f, 3.0);
  const Rendered chosen = rendered(scene, 0);
  const double most = test::counter(chosen, "most_instants");
  ASSERT_EQ(test::counter(chosen, "instants_per_pixel"), most);
  ASSERT_EQ(std::fmod(most, 2.0), 1.0);
  const Rendered stills = rendered(scene, static_cast<int>(most));
  EXPECT_GE(test::psnr_db(chosen.image, stills.image), 120.0);
}

}  // namespace
}  // namespace swept
