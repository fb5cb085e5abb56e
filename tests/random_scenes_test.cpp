// The exact renderer against the reference on scenes that nobody chose: random discs, motions and image
// models.
#include <cmath>
#include <random>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "tests/counter.h"
#include "tests/image_difference.h"

namespace swept {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}

  double in(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  /// Evenly over the orders of magnitude.
  double of_any_size(double low, double high) { return std::exp(in(std::log(low), std::log(high))); }
  bool chance(double probability) { return in(0.0, 1.0) < probability; }
  int below(int count) { return static_cast<int>(in(0.0, count)); }
  Vector3d in_cube() { return {in(-1.0, 1.0), in(-1.0, 1.0), in(-1.0, 1.0)}; }

 private:
  std::mt19937_64 bits_;
};

ImageModel random_model(Random& random) {
  ImageModel model;
  if (random.chance(0.5)) model.delta = random.of_any_size(0.02, 50.0);
  if (random.chance(0.3)) model.coverage = Coverage::hard;
  if (random.chance(0.5)) model.edge_weight = random.of_any_size(1e-3, 1.0);
  if (random.chance(0.5)) model.depth_tolerance = random.chance(0.2) ? 0.0 : random.of_any_size(1e-4, 100.0);
  if (random.chance(0.5)) model.filter_radius_px = random.chance(0.4) ? 0.0 : random.of_any_size(0.01, 30.0);
  if (random.chance(0.2)) model.segments = 1 + random.below(20);
  return model;
}

/// Around the origin; of about one size, `thin` times as wide as long.
SurfelPose random_pose(Random& random, int count, double size, double thin) {
  SurfelPose pose;
  for (int i = 0; i < count; ++i) {
    const Vector3d normal = (random.in_cube() - Vector3d(0.0, 0.0, 0.5)).normalized();
    const Vector3d side = normal.unitOrthogonal();
    pose.position.push_back(random.in_cube().cwiseProduct(Vector3d(2.0, 1.5, 2.0)));
    pose.axis_u.push_back((size * random.in(0.3, 1.3) * side).cast<float>());
    pose.axis_v.push_back((thin * size * random.in(0.3, 1.3) * normal.cross(side)).cast<float>());
  }
  return pose;
}

/// Up to 65 discs of about one speed, some all of one velocity, some moving between two poses, some turning
/// as a whole, some transparent.
Object random_object(Random& random) {
  Object object;
  object.two_sided = random.chance(0.8);
  const int count = random.chance(0.33) ? 1 + random.below(4) : 5 + random.below(60);
  const double size = random.of_any_size(1e-3, 30.0), speed = random.of_any_size(1e-4, 300.0);
  const double thin = random.chance(0.3) ? random.of_any_size(1e-4, 1.0) : 1.0;
  const bool rigid = random.chance(0.5), transparent = random.chance(0.3);
  const Vector3d velocity = speed * random.in_cube();
  const bool between_poses = random.chance(0.2);
  object.cloud.keys.push_back({-0.5, random_pose(random, count, size, thin)});
  if (between_poses) object.cloud.keys.push_back({0.5, random_pose(random, count, size, thin)});
  for (int i = 0; i < count; ++i) {
    if (!between_poses)
      object.cloud.velocity.push_back((rigid ? velocity : Vector3d(speed * random.in_cube())).cast<float>());
    object.cloud.color.push_back((0.5 * random.in_cube() + Vector3d::Constant(0.5)).cast<float>());
    if (transparent) object.cloud.opacity.push_back(static_cast<float>(random.in(0.0, 1.0)));
  }

  TransformKey key;
  key.frame = -0.5;
  key.translate = {0.0, 0.0, 3.5};
  object.transform.keys.push_back(key);
  if (random.chance(0.3)) {
    key.frame = 0.5;
    key.translate += 0.3 * random.in_cube();
    key.rotate_axis = random.in_cube().normalized();
    key.rotate_radians = random.in(0.0, 1.5);
    object.transform.keys.push_back(key);
  }
  return object;
}

/// 24 × 18 px; around 3.5 units away, with a focal length of 18 px.
Scene random_scene(unsigned seed) {
  Random random(seed);
  Scene scene;
  scene.film = {24, 18, 0, 0, 0, 0};
  scene.shutter = {-0.5, 0.5};
  scene.camera.poses.emplace_back();
  scene.camera.near = random.chance(0.5) ? 0.1 : random.of_any_size(1e-4, 3.0);
  scene.model = random_model(random);
  for (int objects = 1 + random.below(3); objects > 0; --objects)
    scene.objects.push_back(random_object(random));
  return scene;
}

/// Colour to 80 dB on top of what the reference is off by itself, its estimate being within a factor of √1.5.
/// Depth as much as the tick of a still, 1/1024 of the exposure, moves an edge, 2.8·10⁻⁴ in root mean square,
/// and where surfaces are far behind each other or seldom seen, five times what the reference's colours are
/// off by.
TEST(RandomScenes, AreTheReference) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Scene scene = random_scene(seed);
    const auto rendered = render_abuffer(scene, {.parabolas = false});
    const auto reference = render_reference(scene, {1024, ReferenceMotion::segments});
    ASSERT_TRUE(rendered && reference) << seed;
    const test::ImageDifference off = test::difference_of(rendered->image, reference->image);
    const double own = test::counter(*reference, "reference_error_rmse");
    EXPECT_LE(off.color, std::hypot(1e-4, 1.5 * own)) << seed;
    EXPECT_LE(off.depth, std::hypot(3e-4, 5.0 * own)) << seed;
  }
}

/// In all parabolas are nearer than chords, in fewer segments. A scene of discs that turn may take more, for
/// axes follow them, and one whose chords happen to make up for each other may be farther off.
TEST(RandomScenes, ParabolasAreTruerThanChords) {
  int bent = 0;
  double log_ratio = 0.0, of_parabolas = 0.0, of_chords = 0.0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Scene scene = random_scene(seed);
    const auto parabolas = render_abuffer(scene), chords = render_abuffer(scene, {.parabolas = false});
    ASSERT_TRUE(parabolas && chords) << seed;
    if (test::difference_of(parabolas->image, chords->image).color < 1e-5) continue;
    ++bent;
    const auto truth = render_reference(scene, {512, ReferenceMotion::smooth});
    ASSERT_TRUE(truth) << seed;
    const double off = test::difference_of(parabolas->image, truth->image).color,
                 chords_off = test::difference_of(chords->image, truth->image).color;
    EXPECT_LE(off, std::hypot(1e-4, 2.0 * chords_off)) << seed;
    // The reference is off by about so much itself.
    constexpr double least = 1e-5;
    log_ratio += std::log(std::max(least, off) / std::max(least, chords_off));
    of_parabolas += test::counter(*parabolas, "kernels");
    of_chords += test::counter(*chords, "kernels");
  }
  ASSERT_GE(bent, 10);
  EXPECT_LE(std::exp(log_ratio / bent), 0.6);
  EXPECT_LE(of_parabolas, 0.75 * of_chords);
}

}  // namespace
}  // namespace swept
