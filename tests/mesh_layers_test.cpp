// Layers of meshes (model section 13): against rays that try every triangle, and what geometry says.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "abuffer/layers.h"
#include "abuffer/reference/mesh_layers_at.h"
#include "tests/mesh_scenes.h"

namespace swept {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr LayerChoice all{true, true, true};
const std::vector<std::string> names{"normal.x",  "normal.y",   "normal.z",   "forward.u",
                                     "forward.v", "backward.u", "backward.v", "coverage"};
using Pixel = Eigen::Matrix<double, 8, 1>;

class Layers {
 public:
  explicit Layers(const Scene& scene, int threads = 0) : width_(scene.film.window_width()) {
    RenderControl control;
    control.threads = threads;
    auto channels = render_layers(scene, all, control);
    EXPECT_TRUE(channels.ok()) << channels.error().message();
    if (channels) channels_ = *std::move(channels);
  }
  [[nodiscard]] Pixel at(int x, int y) const {
    Pixel pixel;
    for (std::size_t c = 0; c < 8; ++c) {
      EXPECT_EQ(channels_.at(c).name, names[c]);
      pixel[static_cast<Eigen::Index>(c)] =
          static_cast<double>(channels_.at(c).values.at(static_cast<std::size_t>(y * width_ + x)));
    }
    return pixel;
  }
  [[nodiscard]] const std::vector<ImageChannel>& channels() const { return channels_; }

 private:
  int width_;
  std::vector<ImageChannel> channels_;
};

Pixel judged(const Scene& scene, int x, int y) {
  const reference::LayersOfPixel layers = reference::mesh_layers_at(scene, x, y);
  Pixel pixel;
  pixel << layers.normal, layers.forward, layers.backward, layers.coverage;
  return pixel;
}

/// Pixels that differ from the judge's, of those looked at.
int differ(const Scene& scene) {
  const Layers layers(scene);
  int wrong = 0, covered = 0;
  for (int y = 0; y < scene.film.height; ++y)
    for (int x = 0; x < scene.film.width; ++x) {
      const Pixel truth = judged(scene, x, y), seen = layers.at(x, y);
      covered += truth[7] > 0.0 ? 1 : 0;
      // Motion leaves digits where a place is near the eye.
      const double size = 1.0 + truth.cwiseAbs().maxCoeff();
      if (!((truth - seen).cwiseAbs().maxCoeff() <= 2e-5 * size)) ++wrong;
    }
  EXPECT_GT(covered, scene.film.width * scene.film.height / 4);
  return wrong;
}

Scene soup_scene() {
  Scene scene = test::mesh_stage(48, 36, 0.6);
  scene.objects = {test::triangle_soup(60, 3, true), test::triangle_soup(40, 4, false)};
  std::mt19937 random(5);
  for (Object& object : scene.objects)
    for (SurfelKey& key : object.cloud.keys)
      for (std::size_t i = 0; i < key.pose.size(); ++i) {
        const auto u = [&] { return static_cast<float>(random()) / 2147483648.0f - 1.0f; };
        key.pose.axis_u[i] = {u(), u(), u()};
        key.pose.axis_v[i] = {u(), u(), u()};
      }
  TransformKey a, b;
  a.rotate_axis = b.rotate_axis = Vector3d(1, 2, 3).normalized();
  a.rotate_radians = 0.1;
  b.frame = 1.0;
  b.rotate_radians = 0.4;
  b.scale = a.scale = {1.0, 0.7, 1.2};
  scene.objects[1].transform.keys = {a, b};
  return scene;
}

TEST(MeshLayers, AgreeWithRaysThatTryEveryTriangle) {
  Scene scene = soup_scene();
  EXPECT_EQ(differ(scene), 0);
  for (Object& object : scene.objects) object.two_sided = false;
  scene.objects[0].transform.keys.resize(1);
  scene.objects[0].transform.keys[0].scale = {1, -1, 1};
  EXPECT_EQ(differ(scene), 0) << "one-sided, mirrored";
}

TEST(MeshLayers, FollowTheCamera) {
  Scene scene = soup_scene();
  scene.camera.look_ats.push_back(scene.camera.look_ats[0]);
  scene.camera.look_ats[1].frame = 1.0;
  scene.camera.look_ats[1].eye = {0.3, 0.1, 0.2};
  scene.camera.look_ats[1].target = {0.2, 0.0, 1.3};
  EXPECT_EQ(differ(scene), 0);
}

TEST(MeshLayers, OfASphereAreItsOwnNormals) {
  // 32 × 64 faces with points' normals at its corners: between them the mixture is of second order.
  Scene scene = test::mesh_stage(64, 48, 0.5);
  Object sphere;
  constexpr std::uint32_t rings = 32, sectors = 64;
  for (std::uint32_t j = 0; j <= rings; ++j)
    for (std::uint32_t i = 0; i < sectors; ++i) {
      const double a = M_PI * j / rings, b = 2.0 * M_PI * i / sectors;
      const Vector3d n(std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b));
      test::add_point(sphere, Vector3d(0, 0, 4) + n, {1, 1, 1});
      const Vector3d u = n.unitOrthogonal();
      sphere.cloud.keys[0].pose.axis_u[j * sectors + i] = u.cast<float>();
      sphere.cloud.keys[0].pose.axis_v[j * sectors + i] = n.cross(u).cast<float>();
      if (j == rings) continue;
      const std::uint32_t p = j * sectors + i, q = j * sectors + (i + 1) % sectors;
      sphere.triangles.push_back({p, q, p + sectors});
      sphere.triangles.push_back({q, q + sectors, p + sectors});
    }
  scene.objects = {sphere};
  const Layers layers(scene);
  int seen = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const Vector3d ray((x + 0.5 - 32) / 48, (y + 0.5 - 24) / 48, 1.0);
      const double half = ray.z() * 4.0 / ray.squaredNorm(), rest = 15.0 / ray.squaredNorm();
      // Towards the rim a pixel's mean is not its middle's.
      if (half * half - rest < 0.5) continue;
      const Vector3d normal = (half - std::sqrt(half * half - rest)) * ray - Vector3d(0, 0, 4);
      const Pixel pixel = layers.at(x, y);
      EXPECT_EQ(pixel[7], 1.0);
      EXPECT_LT((pixel.head<3>() - normal).norm(), 0.004) << x << ' ' << y;
      EXPECT_EQ((pixel.segment<4>(3)), Eigen::Vector4d::Zero()) << "nothing moves";
      ++seen;
    }
  EXPECT_GT(seen, 200);
}

TEST(MeshLayers, StandBeforeDiscsThatAreDeeperAndBehindOthers) {
  Scene scene = test::mesh_stage(32, 24, 0.5);
  scene.objects.push_back(test::rectangle({0, 0, 2}, 9, 9, {1, 0, 0}));
  test::move_points(scene.objects[0], {0.5f, 0, 0});
  Object disc;
  test::add_point(disc, {0, 0, 3}, {0, 1, 0}, 9.0f);
  scene.objects.push_back(disc);
  const Pixel mesh = Layers(scene).at(16, 12);
  // 24 px of focal length, 2 deep: half a unit a frame is 6 px.
  EXPECT_NEAR(mesh[3], 6.0, 1e-5);
  EXPECT_NEAR(mesh[5], -6.0, 1e-5);
  EXPECT_EQ(mesh[7], 1.0);
  scene.objects[1].cloud.keys[0].pose.position[0].z() = 1.0;
  const Pixel front = Layers(scene).at(16, 12);
  EXPECT_EQ(front[3], 0.0);
  EXPECT_NEAR(std::abs(front[2]), 1.0, 1e-6);
  // An edge through the middle of pixel 16: half of its places.
  scene.objects = {test::rectangle({-3.0 + 2.0 * 0.5 / 24.0, 0, 2}, 3, 9, {1, 1, 1})};
  EXPECT_EQ(Layers(scene).at(15, 12)[7], 1.0);
  EXPECT_EQ(Layers(scene).at(16, 12)[7], 0.5);
  EXPECT_EQ(Layers(scene).at(17, 12)[7], 0.0);
}

TEST(MeshLayers, HaveNormalsWherePointsHaveNone) {
  Scene scene = test::mesh_stage(16, 12, 0.5);
  scene.objects.push_back(test::rectangle({0, 0, 2}, 9, 9, {1, 0, 0}));
  for (std::size_t i = 0; i < 4; ++i)
    scene.objects[0].cloud.keys[0].pose.axis_u[i] = scene.objects[0].cloud.keys[0].pose.axis_v[i] = {0, 0, 0};
  EXPECT_LT((Layers(scene).at(8, 6).head<3>() - Vector3d(0, 0, -1)).norm(), 1e-6);
}

TEST(MeshLayers, CropsThreadsAndParallelRays) {
  Scene scene = soup_scene();
  const Layers whole(scene);
  const std::vector<ImageChannel> one = Layers(scene, 1).channels();
  for (std::size_t c = 0; c < one.size(); ++c) EXPECT_EQ(one[c].values, whole.channels()[c].values);
  Scene crop = scene;
  crop.film.crop_x = 7, crop.film.crop_y = 5, crop.film.crop_width = 20, crop.film.crop_height = 11;
  const Layers part(crop);
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 20; ++x) EXPECT_EQ(part.at(x, y), whole.at(x + 7, y + 5)) << x << ' ' << y;
}

}  // namespace
}  // namespace swept
