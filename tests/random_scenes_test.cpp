// The exact renderer against the reference on scenes that nobody chose: random discs, motions and image
// models.
#include <cmath>
#include <random>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/reference.h"
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
  if (random.chance(0.5)) model.delta = random.of_any_size(0.5, 20.0);
  if (random.chance(0.3)) model.coverage = Coverage::hard;
  if (random.chance(0.5)) model.edge_weight = random.in(0.02, 1.0);
  if (random.chance(0.5)) model.depth_tolerance = random.of_any_size(1e-3, 100.0);
  if (random.chance(0.4)) model.filter_radius_px = random.chance(0.5) ? 0.0 : random.in(0.0, 3.0);
  return model;
}

/// Up to 65 discs of about one size and speed, some all of one velocity, some transparent.
Object random_object(Random& random) {
  Object object;
  object.two_sided = random.chance(0.8);
  const int count = random.chance(0.33) ? 1 + random.below(4) : 5 + random.below(60);
  const double size = random.of_any_size(0.03, 3.0), speed = random.of_any_size(0.01, 3.0);
  const bool rigid = random.chance(0.5), transparent = random.chance(0.3);
  const Vector3d velocity = speed * random.in_cube();
  SurfelPose pose;
  for (int i = 0; i < count; ++i) {
    const Vector3d normal = (random.in_cube() - Vector3d(0.0, 0.0, 0.5)).normalized();
    const Vector3d side = normal.unitOrthogonal();
    pose.position.push_back(Vector3d(0.0, 0.0, 3.5) + random.in_cube().cwiseProduct(Vector3d(2.0, 1.5, 2.0)));
    pose.axis_u.push_back((size * random.in(0.3, 1.3) * side).cast<float>());
    pose.axis_v.push_back((size * random.in(0.3, 1.3) * normal.cross(side)).cast<float>());
    object.cloud.velocity.push_back((rigid ? velocity : Vector3d(speed * random.in_cube())).cast<float>());
    object.cloud.color.push_back((0.5 * random.in_cube() + Vector3d::Constant(0.5)).cast<float>());
    if (transparent) object.cloud.opacity.push_back(static_cast<float>(random.in(0.0, 1.0)));
  }
  object.cloud.keys.push_back({0.0, std::move(pose)});
  return object;
}

/// 24 × 18 px; from 1.5 to 5.5 units away, with a focal length of 18 px.
Scene random_scene(unsigned seed) {
  Random random(seed);
  Scene scene;
  scene.film = {24, 18, 0, 0, 0, 0};
  scene.shutter = {-0.5, 0.5};
  scene.camera.poses.emplace_back();
  scene.camera.near = 0.1;
  scene.model = random_model(random);
  for (int objects = 1 + random.below(3); objects > 0; --objects)
    scene.objects.push_back(random_object(random));
  return scene;
}

/// Colour to 80 dB on top of what the reference is off by itself, its estimate being within a factor of √1.5.
/// A still stands for 1/1024 of the exposure, and so an edge's time is off by 2.8·10⁻⁴ in root mean square;
/// depth by that times how far surfaces are apart there, about as far as they are away.
TEST(RandomScenes, AreTheReference) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Scene scene = random_scene(seed);
    const auto rendered = render_abuffer(scene);
    const auto reference = render_reference(scene, {1024, 0, ReferenceMotion::segments});
    ASSERT_TRUE(rendered && reference) << seed;
    const test::ImageDifference off = test::difference_of(rendered->image, reference->image);
    EXPECT_LE(off.color, std::hypot(1e-4, 1.5 * test::counter(*reference, "reference_error_rmse"))) << seed;
    EXPECT_LE(off.depth, 3e-4) << seed;
  }
}

}  // namespace
}  // namespace swept
